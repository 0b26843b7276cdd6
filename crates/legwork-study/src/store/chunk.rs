//! A chunk: the bytes of one file of records.
//!
//! The first line is a header (JSON), and each line after it is a record (JSON). The header tells everything that the
//! file must agree with, so that a chunk is sound if and only if its header is, to the byte, the one it should have.

use std::ops::Range;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

const FORMAT: u32 = 1;

/// No header is longer: braces and keys, a hash of 32 digits, two numbers of up to 20, a checksum of 16.
pub(super) const HEADER_BYTES: u64 = 160;

/// What a chunk must agree with.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Hash of the study.
    pub(super) study: u128,
    /// Indices of the records.
    pub(super) range: Range<u64>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    format: u32,
    study: String,
    first: u64,
    count: u64,
    /// Of all that comes after the header's line.
    xxh3: String,
}

impl Header {
    fn new(place: &Place, body: &[u8]) -> Self {
        Self {
            format: FORMAT,
            study: format!("{:032x}", place.study),
            first: place.range.start,
            count: place.range.end - place.range.start,
            xxh3: format!("{:016x}", xxh3_64(body)),
        }
    }

    fn line(&self) -> String {
        serde_json::to_string(self).expect("a header is plain data")
    }
}

/// The bytes of a chunk with these records.
///
/// # Errors
/// The index and the problem of a record that JSON cannot carry there and back, as one with a NaN.
pub(super) fn encode<T: Serialize + DeserializeOwned>(place: &Place, records: &[T]) -> Result<Vec<u8>, (u64, String)> {
    let mut body = Vec::new();
    for (index, record) in place.range.clone().zip(records) {
        let begin = body.len();
        serde_json::to_writer(&mut body, record).map_err(|error| (index, error.to_string()))?;
        // A NaN is written as null. Better found here than when all is done.
        serde_json::from_slice::<T>(&body[begin..]).map_err(|error| (index, error.to_string()))?;
        body.push(b'\n');
    }
    let mut bytes = Header::new(place, &body).line().into_bytes();
    bytes.push(b'\n');
    bytes.append(&mut body);
    Ok(bytes)
}

/// The lines of the records in a chunk that is whole and belongs here.
///
/// # Errors
/// What is wrong with it, in words.
pub(super) fn verify<'a>(place: &Place, bytes: &'a [u8]) -> Result<&'a [u8], String> {
    let end = bytes.iter().position(|&byte| byte == b'\n').ok_or("is cut short in its first line")?;
    let (line, body) = (&bytes[..end], &bytes[end + 1..]);
    let expected = Header::new(place, body);
    if line == expected.line().as_bytes() {
        return Ok(body);
    }
    let Ok(found) = serde_json::from_slice::<Header>(line) else {
        return Err("has no valid header in its first line".to_owned());
    };
    Err(if found.format != expected.format {
        format!("has format {}, this program reads {}", found.format, expected.format)
    } else if found.study != expected.study {
        format!("belongs to study {}, expected {}", found.study, expected.study)
    } else if (found.first, found.count) != (expected.first, expected.count) {
        let Header { first, count, .. } = &expected;
        format!("holds {} records from {}, expected {count} from {first}", found.count, found.first)
    } else {
        "is damaged or cut short: its content does not match its checksum".to_owned()
    })
}

/// The records in the lines that [`verify`] returns.
///
/// # Errors
/// A line that is no such record, in words.
pub(super) fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<Vec<T>, String> {
    let records = serde_json::Deserializer::from_slice(body).into_iter();
    records.collect::<Result<_, _>>().map_err(|error| format!("holds a record that cannot be read: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place() -> Place {
        Place { study: 0xabc, range: 64..67 }
    }

    #[test]
    fn doubles_come_back_to_the_bit() {
        let records = [0.1 + 0.2, -0.0, f64::MIN_POSITIVE / 3.0];
        let bytes = encode(&place(), &records).unwrap();
        let read: Vec<f64> = decode(verify(&place(), &bytes).unwrap()).unwrap();
        assert!(read.iter().zip(&records).all(|(a, b)| a.to_bits() == b.to_bits()) && read.len() == 3);
    }

    #[test]
    fn any_changed_or_lost_byte_is_noticed() {
        let bytes = encode(&place(), &["a", "b", "c"].map(str::to_owned)).unwrap();
        for at in 0..bytes.len() {
            assert!(verify(&place(), &bytes[..at]).is_err(), "cut at {at}");
            for bit in 0..8 {
                let mut changed = bytes.clone();
                changed[at] ^= 1 << bit;
                assert!(verify(&place(), &changed).is_err(), "bit {bit} of byte {at}");
            }
        }
        assert!(verify(&place(), &[&bytes[..], b"\n"].concat()).is_err(), "something appended");
    }

    #[test]
    fn a_chunk_in_another_place_says_where_it_belongs() {
        let bytes = encode(&place(), &[1, 2, 3]).unwrap();
        let problem = |place: Place| verify(&place, &bytes).unwrap_err();
        assert!(
            problem(Place { study: 0xdef, ..place() }).contains("belongs to study 00000000000000000000000000000abc")
        );
        assert!(problem(Place { range: 0..3, ..place() }).contains("holds 3 records from 64, expected 3 from 0"));
        let newer = String::from_utf8(bytes.clone()).unwrap().replacen("\"format\":1", "\"format\":2", 1);
        assert!(verify(&place(), newer.as_bytes()).unwrap_err().contains("has format 2"));
    }

    #[test]
    fn a_nan_is_refused_and_named() {
        let (index, problem) = encode(&place(), &[1.0, f64::NAN, 2.0]).unwrap_err();
        assert_eq!(index, 65, "{problem}");
    }

    #[test]
    fn no_header_is_longer_than_is_counted_with() {
        let place = Place { study: u128::MAX, range: 0..u64::MAX };
        // The first index and the count, both at their longest
        let header = Header { first: u64::MAX, ..Header::new(&place, b"") };
        assert!((header.line().len() as u64) < HEADER_BYTES, "{}", header.line().len());
    }
}
