//! PNG files, as much of the format as 8-bit RGB needs.
//!
//! Each row is stored as the difference to its left or upper neighbour, whichever is smaller, which is what
//! makes flat plots compress well. See the PNG specification, <https://www.w3.org/TR/png-3/>.

use std::io::{self, Write};

use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};

const BYTES_PER_PIXEL: usize = 3;

/// Writes an image of `width` times `height` pixels, three bytes each, row by row from the top.
pub(super) fn write(w: &mut dyn Write, width: u32, height: u32, rgb: &[u8]) -> io::Result<()> {
    let row_bytes = width as usize * BYTES_PER_PIXEL;
    if row_bytes == 0 || rgb.len() != row_bytes * height as usize {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the picture has no pixels"));
    }
    w.write_all(b"\x89PNG\r\n\x1a\n")?;
    let mut header = Vec::with_capacity(13);
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    // Eight bits a channel, RGB, the only compression and filter method, not interlaced.
    header.extend([8, 2, 0, 0, 0]);
    chunk(w, b"IHDR", &header)?;

    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    let mut above = vec![0; row_bytes];
    for row in rgb.chunks(row_bytes) {
        encoder.write_all(&filtered(row, &above))?;
        above.copy_from_slice(row);
    }
    chunk(w, b"IDAT", &encoder.finish()?)?;
    chunk(w, b"IEND", &[])
}

/// The row as differences, led by the number of the filter: 1 left, 2 up.
fn filtered(row: &[u8], above: &[u8]) -> Vec<u8> {
    let left = std::iter::repeat_n(&0, BYTES_PER_PIXEL).chain(row);
    let sub: Vec<u8> = row.iter().zip(left).map(|(a, b)| a.wrapping_sub(*b)).collect();
    let up: Vec<u8> = row.iter().zip(above).map(|(a, b)| a.wrapping_sub(*b)).collect();
    // Small differences of either sign are cheap.
    let cost = |bytes: &[u8]| bytes.iter().map(|&b| u64::from((b as i8).unsigned_abs())).sum::<u64>();
    let (number, best) = if cost(&sub) < cost(&up) { (1, sub) } else { (2, up) };
    let mut line = Vec::with_capacity(best.len() + 1);
    line.push(number);
    line.extend(best);
    line
}

fn chunk(w: &mut dyn Write, kind: &[u8; 4], data: &[u8]) -> io::Result<()> {
    let mut crc = Crc::new();
    crc.update(kind);
    crc.update(data);
    w.write_all(&(data.len() as u32).to_be_bytes())?;
    w.write_all(kind)?;
    w.write_all(data)?;
    w.write_all(&crc.sum().to_be_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;

    #[test]
    fn the_pixels_come_back() {
        let (width, height) = (7, 5);
        let rgb: Vec<u8> = (0..width * height * 3).map(|i| (i * i % 251) as u8).collect();
        let mut file = Vec::new();
        write(&mut file, width, height, &rgb).unwrap();
        let length = u32::from_be_bytes(file[33..37].try_into().unwrap()) as usize;
        assert_eq!(&file[37..41], b"IDAT");
        let mut lines = Vec::new();
        flate2::read::ZlibDecoder::new(&file[41..41 + length]).read_to_end(&mut lines).unwrap();
        let mut read: Vec<u8> = Vec::new();
        for line in lines.chunks(22) {
            let start = read.len();
            for (i, byte) in line[1..].iter().enumerate() {
                let back = if line[0] == 1 {
                    i.checked_sub(3).map(|_| 3)
                } else {
                    start.checked_sub(21).map(|_| 21)
                };
                let neighbour = back.map_or(0, |n| read[start + i - n]);
                read.push(byte.wrapping_add(neighbour));
            }
        }
        assert_eq!(read, rgb);
    }

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        assert!(write(&mut Vec::new(), 0, 3, &[]).is_err());
    }
}
