//! Fingerprint of the mesh of a system, by which a state is known to belong to it.

use super::System;

/// Start and factor of the hash function of Fowler, Noll and Vo (FNV-1a, 64 bits).
const FNV: [u64; 2] = [0xcbf2_9ce4_8422_2325, 0x0000_0100_0000_01b3];

impl System {
    /// Hash of the nodal vectors in the reference configuration and of the elements with their vectors. Systems of the same mesh, bodies and elements
    /// have the same one, whatever their materials, loads and supports; others have another one.
    pub fn fingerprint(&self) -> u64 {
        let mut hash = FNV[0];
        let mut take = |bytes: &[u8]| {
            for byte in bytes {
                hash = (hash ^ u64::from(*byte)).wrapping_mul(FNV[1]);
            }
        };
        for x in self.coordinates.reference.as_flattened() {
            // The zeros of both signs are one place.
            take(&(x + 0.0).to_le_bytes());
        }
        for group in self.groups.iter() {
            take(group.name().as_bytes());
            for element in 0..group.len() {
                group.vectors(element).iter().for_each(|v| take(&v.to_le_bytes()));
            }
        }
        hash
    }
}
