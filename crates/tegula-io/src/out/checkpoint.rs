//! Checkpoints: complete data to resume a run as if it had not been interrupted.
//!
//! A binary file, little endian:
//!
//! | bytes | meaning |
//! |---|---|
//! | 8 | the letters `TEGULACP` |
//! | 4 | format version |
//! | 8 | fingerprint of the model |
//! | body | the data in [MessagePack](https://msgpack.org), with the names of their fields |
//! | 4 | CRC-32 checksum of everything before it |
//!
//! Numbers are stored bit by bit, so a resumed run repeats the original exactly. The names of the fields show where a
//! program of another version stores other data.

use std::io::{self, BufWriter, Write};
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::file::{OutputError, write_whole};

const MAGIC: &[u8; 8] = b"TEGULACP";
const VERSION: u32 = 10;
/// Letters, version and fingerprint.
const HEADER: usize = 20;
const CHECKSUM: usize = 4;

/// FNV-1a hash (Fowler, Noll, Vo) of a text or of the bytes of a file, 64 bits, with the standard basis and prime; the same
/// on every machine and in every version.
pub fn fingerprint(data: impl AsRef<[u8]>) -> u64 {
    let add = |hash: u64, &byte: &u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    data.as_ref().iter().fold(0xcbf2_9ce4_8422_2325, add)
}

/// Writer that passes bytes on and computes their checksum: the arrays of a large model are not copied.
struct Checked<W> {
    writer: W,
    checksum: crc32fast::Hasher,
}

impl<W: Write> Write for Checked<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.writer.write(bytes)?;
        self.checksum.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Writes a checkpoint of the model with a [`fingerprint`], whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn save_checkpoint(
    path: &Path,
    model_fingerprint: u64,
    data: &impl Serialize,
) -> Result<(), OutputError> {
    write_whole(path, |w| {
        let checked = Checked { writer: w, checksum: crc32fast::Hasher::new() };
        let mut w = BufWriter::new(checked);
        w.write_all(MAGIC)?;
        w.write_all(&VERSION.to_le_bytes())?;
        w.write_all(&model_fingerprint.to_le_bytes())?;
        rmp_serde::encode::write_named(&mut w, data).map_err(io::Error::other)?;
        let Checked { writer, checksum } = w.into_inner().map_err(io::IntoInnerError::into_error)?;
        writer.write_all(&checksum.finalize().to_le_bytes())
    })
}

/// Reads a checkpoint of the model with a [`fingerprint`].
///
/// # Errors
/// The file cannot be read, is damaged, or belongs to another model or to another version of the format.
pub fn load_checkpoint<T: DeserializeOwned>(path: &Path, model_fingerprint: u64) -> Result<T, OutputError> {
    let bytes = std::fs::read(path).map_err(|cause| OutputError::read(path, cause))?;
    let (found, body) =
        parse(&bytes).map_err(|(problem, remedy)| OutputError::damaged(path, problem, remedy))?;
    if found != model_fingerprint {
        let path = path.to_path_buf();
        return Err(OutputError::OtherModel { path, found, expected: model_fingerprint });
    }
    rmp_serde::from_slice(body)
        .map_err(|cause| OutputError::damaged(path, format!("its data cannot be read: {cause}"), EARLIER))
}

const EARLIER: &str = "Run without `--resume` to start anew";

/// Fingerprint and body of the checkpoint in these bytes, or the problem and its remedy.
fn parse(bytes: &[u8]) -> Result<(u64, &[u8]), (String, &'static str)> {
    let start = &bytes[..bytes.len().min(MAGIC.len())];
    if !MAGIC.starts_with(start) || bytes.is_empty() {
        return Err(("it is not a checkpoint of tegula".into(), "Check the name"));
    }
    let cut_off = || (format!("it is cut off after {} bytes", bytes.len()), EARLIER);
    let (header, rest) = bytes.split_at_checked(HEADER).ok_or_else(cut_off)?;
    let (version, fingerprint) = header[MAGIC.len()..].split_at(4);
    let version = u32::from_le_bytes(version.try_into().map_err(|_| cut_off())?);
    if version != VERSION {
        let problem = format!("it has format version {version}, and this program reads version {VERSION}");
        return Err((
            problem,
            "Use the version of tegula that wrote it, or run without `--resume` to start anew",
        ));
    }
    let (body, checksum) =
        rest.len().checked_sub(CHECKSUM).map(|end| rest.split_at(end)).ok_or_else(cut_off)?;
    if checksum != crc32fast::hash(&bytes[..bytes.len() - CHECKSUM]).to_le_bytes() {
        return Err(("it is damaged or cut off (its checksum is wrong)".into(), EARLIER));
    }
    Ok((u64::from_le_bytes(fingerprint.try_into().map_err(|_| cut_off())?), body))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use std::fs;

    #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
    struct Data {
        step: u64,
        time: f64,
        field: Vec<[f64; 3]>,
        empty: Vec<f64>,
        values: Vec<f64>,
        word: String,
        met: Option<usize>,
    }

    fn sample() -> Data {
        Data {
            step: 7,
            time: 0.1 + 0.2,
            field: vec![[0.1, -0.0, f64::INFINITY], [f64::MIN_POSITIVE / 2.0, f64::MAX, 1.0]],
            empty: vec![],
            values: (0..1000).map(|i| f64::from(i).sin()).collect(),
            word: "é".into(),
            met: None,
        }
    }

    #[test]
    fn everything_survives_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c");
        let mut data = sample();
        save_checkpoint(&path, 5, &data).unwrap();
        let loaded: Data = load_checkpoint(&path, 5).unwrap();
        assert_eq!(loaded, data);
        assert_eq!(loaded.field[0][1].to_bits(), (-0.0_f64).to_bits());
        let odd_nan = f64::from_bits(0x7ff8_0000_dead_beef);
        data.field[0][0] = odd_nan;
        save_checkpoint(&path, 5, &data).unwrap();
        assert_eq!(load_checkpoint::<Data>(&path, 5).unwrap().field[0][0].to_bits(), odd_nan.to_bits());
    }

    #[test]
    fn no_truncation_and_no_flipped_byte_goes_unseen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c");
        save_checkpoint(&path, 5, &sample()).unwrap();
        let good = fs::read(&path).unwrap();
        assert!(parse(&good).is_ok());
        for length in (0..good.len()).step_by(37).chain([1, 7, 8, 19, 20, 23, 24, good.len() - 1]) {
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
    fn data_of_another_program_are_refused() {
        #[derive(Serialize)]
        struct Other {
            step: u64,
            time: f64,
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c");
        save_checkpoint(&path, 5, &Other { step: 7, time: 0.3 }).unwrap();
        let message = load_checkpoint::<Data>(&path, 5).unwrap_err().to_string();
        assert!(message.contains("missing field `field`") && message.contains("anew"), "{message}");
    }

    #[test]
    fn messages_say_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("run.checkpoint");
        let load = |fingerprint| load_checkpoint::<Data>(&path, fingerprint);
        let message = load(5).unwrap_err().to_string();
        assert!(message.contains("run.checkpoint"), "{message}");
        fs::write(&path, "hello, this is a letter").unwrap();
        assert!(load(5).unwrap_err().to_string().contains("not a checkpoint"));
        save_checkpoint(&path, fingerprint("model"), &sample()).unwrap();
        let message = load(1).unwrap_err().to_string();
        assert!(message.contains("another model") && message.contains("anew"), "{message}");
        assert!(load(fingerprint("model")).is_ok());
        for other in [VERSION - 1, VERSION + 1] {
            let mut bytes = fs::read(&path).unwrap();
            bytes[8..12].copy_from_slice(&other.to_le_bytes());
            fs::write(&path, bytes).unwrap();
            let message = load(5).unwrap_err().to_string();
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
