//! Reading and writing of numbers: little-endian, and LEB128 for those that are mostly small.

use crate::error::{Error, Result};

/// A cursor over one part of a file. Every read is checked.
pub struct Reader<'a> {
    part: &'static str,
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    pub fn new(part: &'static str, bytes: &'a [u8]) -> Self {
        Reader { part, rest: bytes }
    }

    pub fn error(&self, what: &str) -> Error {
        Error::malformed(self.part, what)
    }

    pub fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        if n > self.rest.len() {
            return Err(self.error("it ends too early"));
        }
        let (taken, rest) = self.rest.split_at(n);
        self.rest = rest;
        Ok(taken)
    }

    pub fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    pub fn u16(&mut self) -> Result<u16> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    pub fn u32(&mut self) -> Result<u32> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// An unsigned LEB128 number of at most 32 bits.
    pub fn varint(&mut self) -> Result<u32> {
        let mut value = 0u32;
        for shift in (0..35).step_by(7) {
            let byte = self.u8()?;
            let bits = u32::from(byte & 0x7f);
            if shift == 28 && bits > 0xf {
                break;
            }
            value |= bits << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(self.error("a number that is too large"))
    }

    /// An unsigned LEB128 number of at most 63 bits.
    pub fn long_varint(&mut self) -> Result<u64> {
        let mut value = 0u64;
        for shift in (0..63).step_by(7) {
            let byte = self.u8()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(self.error("a number that is too large"))
    }

    /// `base + varint`, refused where it overflows.
    pub fn ahead_of(&mut self, base: u32) -> Result<u32> {
        let step = self.varint()?;
        base.checked_add(step).ok_or_else(|| self.error("a number that is too large"))
    }

    /// A number of items of which each takes at least `least` bytes of what is left.
    pub fn count(&mut self, least: usize) -> Result<usize> {
        let count = self.varint()? as usize;
        if count > self.rest.len() / least {
            return Err(self.error("it ends too early"));
        }
        Ok(count)
    }

    /// All that is left.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    pub fn finish(self) -> Result<()> {
        if self.rest.is_empty() { Ok(()) } else { Err(self.error("bytes are left over")) }
    }
}

/// Appends an unsigned LEB128 number.
#[cfg(feature = "encode")]
pub fn push_varint(out: &mut Vec<u8>, value: u32) {
    push_long_varint(out, value.into());
}

/// Appends an unsigned LEB128 number below 2⁶³.
#[cfg(feature = "encode")]
pub fn push_long_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[cfg(all(test, feature = "encode"))]
mod tests {
    use super::*;

    #[test]
    fn varints_round_trip_and_refuse_excess() {
        for value in [0, 1, 127, 128, 300, 1 << 14, (1 << 28) - 1, 1 << 28, u32::MAX] {
            let mut out = Vec::new();
            push_varint(&mut out, value);
            let mut reader = Reader::new("test", &out);
            assert_eq!(reader.varint(), Ok(value));
            reader.finish().unwrap();
        }
        for value in [0, 300, 1 << 35, (1 << 63) - 1] {
            let mut out = Vec::new();
            push_long_varint(&mut out, value);
            assert_eq!(Reader::new("test", &out).long_varint(), Ok(value));
        }
        assert!(Reader::new("test", &[0xff; 10]).long_varint().is_err());
        for bad in [&[0xff, 0xff, 0xff, 0xff, 0x1f][..], &[0x80; 6], &[0x80]] {
            assert!(Reader::new("test", bad).varint().is_err());
        }
    }

    #[test]
    fn a_count_cannot_promise_more_than_there_is() {
        assert!(Reader::new("test", &[200, 1, 0, 0]).count(1).is_err());
    }
}
