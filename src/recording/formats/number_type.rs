//! Numbers as bytes: the element types of array and bag files, in either byte order.

/// The byte order of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

/// How one number is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl NumberType {
    /// Bytes of one number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// All whole numbers in the bytes. Integers of 64 bits are rounded to the nearest double.
    pub fn decode(self, bytes: &[u8], order: ByteOrder) -> Vec<f64> {
        match self {
            Self::I8 => bytes.iter().map(|&byte| f64::from(byte as i8)).collect(),
            Self::U8 => bytes.iter().map(|&byte| f64::from(byte)).collect(),
            Self::I16 => each(bytes, order, |b| f64::from(i16::from_le_bytes(b))),
            Self::U16 => each(bytes, order, |b| f64::from(u16::from_le_bytes(b))),
            Self::I32 => each(bytes, order, |b| f64::from(i32::from_le_bytes(b))),
            Self::U32 => each(bytes, order, |b| f64::from(u32::from_le_bytes(b))),
            Self::I64 => each(bytes, order, |b| i64::from_le_bytes(b) as f64),
            Self::U64 => each(bytes, order, |b| u64::from_le_bytes(b) as f64),
            Self::F32 => each(bytes, order, |b| f64::from(f32::from_le_bytes(b))),
            Self::F64 => each(bytes, order, f64::from_le_bytes),
        }
    }
}

/// Decodes groups of N bytes, given to `number` with the least significant byte first.
fn each<const N: usize>(bytes: &[u8], order: ByteOrder, number: fn([u8; N]) -> f64) -> Vec<f64> {
    let (groups, _) = bytes.as_chunks::<N>();
    let decode = |&group: &[u8; N]| match order {
        ByteOrder::Little => number(group),
        ByteOrder::Big => {
            let mut reversed = group;
            reversed.reverse();
            number(reversed)
        }
    };
    groups.iter().map(decode).collect()
}
