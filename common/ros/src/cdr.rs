//! Messages as bytes of the Common Data Representation.

use crate::interface::RosMessage;
use byteorder::LittleEndian;

/// Encapsulation header: plain CDR, little-endian, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message that has no bytes.
#[derive(Debug, thiserror::Error)]
pub enum CdrError {
    /// A field is of a shape that CDR does not know.
    #[error("a {0} cannot be serialised")]
    Shape(&'static str, #[source] cdr_encoding::Error),
    /// Lengths of arrays and texts are counted in 32 bits.
    #[error("a {0} is larger than 4 GiB")]
    TooLarge(&'static str),
}

/// The bytes of a message: the encapsulation header `00 01 00 00`, then little-endian CDR, aligned from behind the header.
///
/// # Errors
/// More bytes than lengths can count.
///
/// # Source
/// OMG, "DDS Interoperability Wire Protocol (RTPS)" 2.2, 10 "Data Encapsulation"; MCAP's message encoding `cdr`.
pub fn cdr<M: RosMessage>(message: &M) -> Result<Vec<u8>, CdrError> {
    let mut bytes = HEADER.to_vec();
    cdr_encoding::to_writer::<M, LittleEndian, _>(&mut bytes, message).map_err(|e| CdrError::Shape(M::NAME, e))?;
    if u32::try_from(bytes.len()).is_err() {
        return Err(CdrError::TooLarge(M::NAME));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::msg::builtin_interfaces::Time;
    use crate::msg::nav_msgs::{Int8Array, OccupancyGrid};
    use crate::msg::std_msgs::Header;

    #[test]
    fn numbers_are_aligned_from_behind_the_header() {
        let header = Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".to_owned() };
        let bytes = cdr(&header).unwrap();
        assert_eq!(bytes, [0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0, b'm', b'a', b'p', 0]);
    }

    #[test]
    fn a_grid_is_read_back_from_its_bytes() {
        let grid = OccupancyGrid { data: Int8Array(vec![-1, 0, 100]), ..OccupancyGrid::default() };
        let bytes = cdr(&grid).unwrap();
        assert_eq!(bytes[bytes.len() - 7..], [3, 0, 0, 0, 0xff, 0, 100]);
        let (read, _) = cdr_encoding::from_bytes::<OccupancyGrid, LittleEndian>(&bytes[HEADER.len()..]).unwrap();
        assert_eq!(read, grid);
    }
}
