//! PNG files of 8-bit RGB.

use std::io::{self, Write};

use png::{BitDepth, ColorType, Encoder, Filter};

/// Writes an image of `width` times `height` pixels, three bytes each, row by row from the top.
pub(super) fn write(w: &mut dyn Write, width: u32, height: u32, rgb: &[u8]) -> io::Result<()> {
    let mut encoder = Encoder::new(w, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // Flat plots compress well as differences to neighbours.
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(rgb)?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pixels_come_back() {
        let (width, height) = (7, 5);
        let rgb: Vec<u8> = (0..width * height * 3).map(|i| (i * i % 251) as u8).collect();
        let mut file = Vec::new();
        write(&mut file, width, height, &rgb).unwrap();
        let mut reader = png::Decoder::new(io::Cursor::new(file)).read_info().unwrap();
        let mut read = vec![0; reader.output_buffer_size().unwrap()];
        let found = reader.next_frame(&mut read).unwrap();
        assert_eq!((found.width, found.height, found.color_type), (width, height, ColorType::Rgb));
        assert_eq!(read, rgb);
    }

    #[test]
    fn a_picture_without_pixels_is_an_error() {
        assert!(write(&mut Vec::new(), 0, 3, &[]).is_err());
        assert!(write(&mut Vec::new(), 2, 3, &[0; 17]).is_err());
    }
}
