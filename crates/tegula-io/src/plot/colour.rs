//! Colours: a palette for colour-blind readers, and a map from values to colours.
//!
//! The palette is that of M. Okabe and K. Ito, "Color Universal Design" (2008), without its yellow, which is
//! lost on white. The map follows "viridis" (S. van der Walt, N. Smith; CC0): even steps of lightness, readable in
//! grey.

/// A colour, channels from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rgb(pub [f64; 3]);

impl Rgb {
    /// Black.
    pub const BLACK: Self = Self([0.0; 3]);
    /// White.
    pub const WHITE: Self = Self([1.0; 3]);
    /// Letters.
    pub const INK: Self = Self::grey(0.16);
    /// Less important letters.
    pub const QUIET: Self = Self::grey(0.42);
    /// Grid lines.
    pub const GRID: Self = Self::grey(0.89);
    /// Values that are not finite.
    pub const MISSING: Self = Self::grey(0.72);

    /// A grey, 0 black to 1 white.
    pub const fn grey(level: f64) -> Self {
        Self([level; 3])
    }

    /// From `0xRRGGBB`.
    pub const fn hex(code: u32) -> Self {
        Self([
            ((code >> 16) & 255) as f64 / 255.0,
            ((code >> 8) & 255) as f64 / 255.0,
            (code & 255) as f64 / 255.0,
        ])
    }

    /// The colour a share `t` of the way to `other`.
    pub fn mix(self, other: Self, t: f64) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + (other.0[i] - self.0[i]) * t))
    }

    /// Brighter or darker by a factor.
    pub fn scaled(self, factor: f64) -> Self {
        Self(self.0.map(|c| c * factor))
    }

    /// Colour as `#rrggbb`.
    pub fn code(self) -> String {
        let [r, g, b] = self.bytes();
        format!("#{r:02x}{g:02x}{b:02x}")
    }

    /// Channels as bytes.
    pub fn bytes(self) -> [u8; 3] {
        self.0.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
    }
}

/// Colours of series in their order.
pub const PALETTE: [Rgb; 7] = [
    Rgb::hex(0x0072b2),
    Rgb::hex(0xd55e00),
    Rgb::hex(0x009e73),
    Rgb::hex(0xcc79a7),
    Rgb::hex(0xe69f00),
    Rgb::hex(0x56b4e9),
    Rgb::hex(0x222222),
];

/// Colour of the series number `index`; repeats after seven.
pub fn palette(index: usize) -> Rgb {
    PALETTE[index % PALETTE.len()]
}

/// Samples of viridis at equal distances.
pub const VIRIDIS: [Rgb; 11] = [
    Rgb::hex(0x440154),
    Rgb::hex(0x482475),
    Rgb::hex(0x414487),
    Rgb::hex(0x355f8d),
    Rgb::hex(0x2a788e),
    Rgb::hex(0x21918c),
    Rgb::hex(0x22a884),
    Rgb::hex(0x44bf70),
    Rgb::hex(0x7ad151),
    Rgb::hex(0xbddf26),
    Rgb::hex(0xfde725),
];

/// Colour of a value between 0 and 1; grey if it is not a number.
pub fn viridis(value: f64) -> Rgb {
    if value.is_nan() {
        return Rgb::MISSING;
    }
    let place = value.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let index = (place as usize).min(VIRIDIS.len() - 2);
    VIRIDIS[index].mix(VIRIDIS[index + 1], place - index as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance by the sRGB weights, without gamma.
    fn luminance(colour: Rgb) -> f64 {
        let [r, g, b] = colour.0;
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    #[test]
    fn the_map_grows_lighter_all_the_way() {
        let steps: Vec<f64> = (0..=100).map(|i| luminance(viridis(f64::from(i) / 100.0))).collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]));
        assert_eq!(viridis(-1.0), viridis(0.0));
        assert_eq!(viridis(f64::INFINITY), viridis(1.0));
        assert_eq!(viridis(f64::NAN), Rgb::MISSING);
    }

    #[test]
    fn hex_and_bytes_agree() {
        assert_eq!(Rgb::hex(0x0172ff).bytes(), [0x01, 0x72, 0xff]);
        assert_eq!(Rgb::hex(0x0172ff).code(), "#0172ff");
        assert_eq!(palette(7), palette(0));
    }
}
