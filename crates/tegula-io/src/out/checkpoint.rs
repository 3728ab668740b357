//! Checkpoints: complete data to resume a run as if it had not been interrupted.
//!
//! A binary file, little endian:
//!
//! | bytes | meaning |
//! |---|---|
//! | 8 | the letters `TEGULACP` |
//! | 4 + 4 | format version, 0 |
//! | 8 | length of the body in bytes |
//! | body | fingerprint, step, time, notes as JSON, number of arrays, and for each its name and its values |
//! | 8 | FNV-1a checksum of everything before it |
//!
//! Texts and arrays are led by their length. Numbers are stored bit by bit, so a resumed run repeats the
//! original exactly.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::Path;

use super::file::{OutputError, write_whole};

const MAGIC: &[u8; 8] = b"TEGULACP";
const VERSION: u32 = 7;
/// Magic, version, reserved word, length of the body.
const HEADER: usize = 24;

/// The state of a run at the end of a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Checkpoint<'a> {
    /// [`fingerprint`] of the model's text: a checkpoint is valid for no other model.
    pub model_fingerprint: u64,
    /// Number of the last completed step.
    pub step: u64,
    /// Time at the end of that step.
    pub time: f64,
    /// Named arrays: positions, velocities, multipliers, history variables.
    pub arrays: BTreeMap<String, Cow<'a, [f64]>>,
    /// Further data, for example the number of rows of each history.
    pub notes: serde_json::Value,
}

/// FNV-1a hash of a text or of the bytes of a file, 64 bits; the same on every machine and in every version.
pub fn fingerprint(data: impl AsRef<[u8]>) -> u64 {
    fnv1a(data.as_ref())
}

/// Fowler–Noll–Vo hash 1a with the standard 64-bit basis and prime.
fn fnv1a(bytes: &[u8]) -> u64 {
    fnv1a_from(FNV_BASIS, bytes)
}

const FNV_BASIS: u64 = 0xcbf2_9ce4_8422_2325;

/// The hash with more bytes after those that gave `hash`.
fn fnv1a_from(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// Passes bytes on and hashes them: the arrays of a large model are not copied.
struct Hashing<W> {
    writer: W,
    hash: u64,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.writer.write(bytes)?;
        self.hash = fnv1a_from(self.hash, &bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

impl Checkpoint<'_> {
    /// Writes the checkpoint, whole or not at all.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        let notes = serde_json::to_vec(&self.notes)
            .map_err(|e| OutputError::refused(path, format!("its notes cannot be written: {e}")))?;
        let lengths = self.arrays.iter().map(|(name, values)| 16 + name.len() + 8 * values.len());
        let body = 5 * 8 + notes.len() + lengths.sum::<usize>();
        write_whole(path, |w| {
            let (mut w, mut bytes) = (Hashing { writer: w, hash: FNV_BASIS }, Vec::new());
            w.write_all(MAGIC)?;
            w.write_all(&VERSION.to_le_bytes())?;
            w.write_all(&0_u32.to_le_bytes())?;
            for number in [body as u64, self.model_fingerprint, self.step, self.time.to_bits()] {
                w.write_all(&number.to_le_bytes())?;
            }
            put_text(&mut w, &notes)?;
            w.write_all(&(self.arrays.len() as u64).to_le_bytes())?;
            for (name, values) in &self.arrays {
                put_text(&mut w, name.as_bytes())?;
                w.write_all(&(values.len() as u64).to_le_bytes())?;
                for some in values.chunks(512) {
                    bytes.clear();
                    bytes.extend(some.iter().flat_map(|x| x.to_le_bytes()));
                    w.write_all(&bytes)?;
                }
            }
            let hash = w.hash;
            w.write_all(&hash.to_le_bytes())
        })
    }

    /// Reads a checkpoint.
    pub fn load(path: &Path) -> Result<Checkpoint<'static>, OutputError> {
        let bytes = std::fs::read(path).map_err(|cause| OutputError::read(path, cause))?;
        parse(&bytes).map_err(|(problem, remedy)| OutputError::damaged(path, problem, remedy))
    }

    /// Reads a checkpoint of the model with this fingerprint, and refuses that of any other.
    pub fn load_for(path: &Path, model_fingerprint: u64) -> Result<Checkpoint<'static>, OutputError> {
        let checkpoint = Checkpoint::load(path)?;
        let found = checkpoint.model_fingerprint;
        if found != model_fingerprint {
            let path = path.to_path_buf();
            return Err(OutputError::OtherModel { path, found, expected: model_fingerprint });
        }
        Ok(checkpoint)
    }
}

fn put_text(w: &mut impl Write, text: &[u8]) -> io::Result<()> {
    w.write_all(&(text.len() as u64).to_le_bytes())?;
    w.write_all(text)
}

const EARLIER: &str = "Run without `--resume` to start anew";

/// The checkpoint in these bytes, or the problem and its remedy.
fn parse(bytes: &[u8]) -> Result<Checkpoint<'static>, (String, &'static str)> {
    let start = &bytes[..bytes.len().min(MAGIC.len())];
    if !MAGIC.starts_with(start) || bytes.is_empty() {
        return Err(("it is not a checkpoint of tegula".into(), "Check the name"));
    }
    let mut header = Reader { rest: bytes.get(MAGIC.len()..).unwrap_or_default() };
    let truncated = || (format!("it is cut off after {} bytes", bytes.len()), EARLIER);
    let version = header.u64().ok_or_else(truncated)? as u32;
    if version != VERSION {
        let problem = format!("it has format version {version}, and this program reads version {VERSION}");
        return Err((
            problem,
            "Use the version of tegula that wrote it, or run without `--resume` to start anew",
        ));
    }
    let body_length = header.u64().ok_or_else(truncated)?;
    let body = usize::try_from(body_length).ok().and_then(|n| header.take(n)).ok_or_else(truncated)?;
    let checksum = header.u64().ok_or_else(truncated)?;
    let damaged = || ("it is damaged (its checksum is wrong)".to_owned(), EARLIER);
    if checksum != fnv1a(&bytes[..HEADER + body.len()]) || !header.rest.is_empty() {
        return Err(damaged());
    }
    parse_body(body).ok_or_else(damaged)
}

fn parse_body(body: &[u8]) -> Option<Checkpoint<'static>> {
    let mut reader = Reader { rest: body };
    let model_fingerprint = reader.u64()?;
    let step = reader.u64()?;
    let time = f64::from_bits(reader.u64()?);
    let notes = serde_json::from_slice(reader.text()?).ok()?;
    let count = reader.u64()?;
    let mut arrays = BTreeMap::new();
    for _ in 0..count {
        let name = String::from_utf8(reader.text()?.to_vec()).ok()?;
        let length = usize::try_from(reader.u64()?).ok()?.checked_mul(8)?;
        let values = reader.take(length)?.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b));
        arrays.insert(name, values.collect());
    }
    reader.rest.is_empty().then_some(Checkpoint { model_fingerprint, step, time, arrays, notes })
}

/// Reader that splits parts from the front of a slice; `None` when it is too short.
struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (piece, rest) = self.rest.split_at_checked(length)?;
        self.rest = rest;
        Some(piece)
    }

    fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    fn text(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.u64()?).ok()?;
        self.take(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn sample() -> Checkpoint<'static> {
        let arrays = BTreeMap::from([
            ("q".to_owned(), vec![0.1, -0.0, f64::INFINITY, f64::MIN_POSITIVE / 2.0].into()),
            ("empty".to_owned(), vec![].into()),
            ("λ".to_owned(), (0..1000).map(|i| f64::from(i).sin()).collect()),
        ]);
        let notes = serde_json::json!({"rows": {"energy.csv": 12}, "word": "é"});
        Checkpoint { model_fingerprint: fingerprint("model"), step: 7, time: 0.1 + 0.2, arrays, notes }
    }

    #[test]
    fn everything_survives_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c");
        let mut checkpoint = sample();
        checkpoint.save(&path).unwrap();
        assert_eq!(Checkpoint::load(&path).unwrap(), checkpoint);
        let odd_nan = f64::from_bits(0x7ff8_0000_dead_beef);
        checkpoint.arrays.insert("q".into(), vec![odd_nan].into());
        checkpoint.save(&path).unwrap();
        assert_eq!(Checkpoint::load(&path).unwrap().arrays["q"][0].to_bits(), odd_nan.to_bits());
    }

    #[test]
    fn no_truncation_and_no_flipped_byte_goes_unseen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c");
        sample().save(&path).unwrap();
        let good = fs::read(&path).unwrap();
        for length in (0..good.len()).step_by(37).chain([1, 7, 8, 23, good.len() - 1]) {
            let (problem, _) = parse(&good[..length]).unwrap_err();
            assert!(length == 0 || problem.contains("cut off"), "{length}: {problem}");
        }
        for index in (0..good.len()).step_by(41).chain(0..40) {
            let mut bad = good.clone();
            bad[index] ^= 0x10;
            assert!(parse(&bad).is_err(), "byte {index}");
        }
        let mut longer = good;
        longer.push(0);
        assert!(parse(&longer).is_err());
    }

    #[test]
    fn messages_say_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.checkpoint");
        let message = Checkpoint::load(&path).unwrap_err().to_string();
        assert!(message.contains("run.checkpoint"), "{message}");
        fs::write(&path, "hello, this is a letter").unwrap();
        assert!(Checkpoint::load(&path).unwrap_err().to_string().contains("not a checkpoint"));
        sample().save(&path).unwrap();
        let message = Checkpoint::load_for(&path, 1).unwrap_err().to_string();
        assert!(message.contains("another model") && message.contains("anew"), "{message}");
        assert!(Checkpoint::load_for(&path, fingerprint("model")).is_ok());
        for other in [VERSION - 1, VERSION + 1] {
            let mut bytes = fs::read(&path).unwrap();
            bytes[8..12].copy_from_slice(&other.to_le_bytes());
            fs::write(&path, bytes).unwrap();
            let message = Checkpoint::load(&path).unwrap_err().to_string();
            assert!(message.contains(&format!("format version {other}")), "{message}");
            assert!(message.contains(&format!("reads version {VERSION}")), "{message}");
        }
    }

    #[test]
    fn the_fingerprint_is_the_published_hash() {
        // Test vectors of the FNV authors.
        assert_eq!(fingerprint(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fingerprint("a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fingerprint("foobar"), 0x8594_4171_f739_67e8);
    }
}
