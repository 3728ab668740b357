//! Bob Jenkins' hash lookup3 (`hashlittle` with the initial value 0), the checksum of HDF5's metadata.

/// Checksum of bytes.
pub(super) fn lookup3(bytes: &[u8]) -> u32 {
    let start = 0xdead_beef_u32.wrapping_add(bytes.len() as u32);
    let (mut a, mut b, mut c) = (start, start, start);
    let mut rest = bytes;
    // The last twelve bytes, or fewer, are mixed differently.
    while rest.len() > 12 {
        let (block, after) = rest.split_at(12);
        (a, b, c) = mix(added([a, b, c], block));
        rest = after;
    }
    if rest.is_empty() { c } else { last_mix(added([a, b, c], rest)) }
}

/// Adds up to twelve bytes as three little endian words.
fn added(mut words: [u32; 3], bytes: &[u8]) -> [u32; 3] {
    for (i, byte) in bytes.iter().enumerate() {
        words[i / 4] = words[i / 4].wrapping_add(u32::from(*byte) << (8 * (i % 4)));
    }
    words
}

/// Six lines `a -= c; a ^= rot(c, k); c += b`, in which the names move on by one from line to line.
fn mix([mut a, mut b, mut c]: [u32; 3]) -> (u32, u32, u32) {
    for turn in [4, 6, 8, 16, 19, 4] {
        a = a.wrapping_sub(c) ^ c.rotate_left(turn);
        c = c.wrapping_add(b);
        (a, b, c) = (b, c, a);
    }
    (a, b, c)
}

fn last_mix([mut a, mut b, mut c]: [u32; 3]) -> u32 {
    let less = |x: u32, y: u32, turn: u32| (x ^ y).wrapping_sub(y.rotate_left(turn));
    c = less(c, b, 14);
    a = less(a, c, 11);
    b = less(b, a, 25);
    c = less(c, b, 16);
    a = less(a, c, 4);
    b = less(b, a, 14);
    less(c, b, 24)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_has_the_values_of_its_author() {
        // `driver5` of Jenkins' lookup3.c.
        assert_eq!(lookup3(b""), 0xdead_beef);
        assert_eq!(lookup3(b"Four score and seven years ago"), 0x1777_0551);
    }
}
