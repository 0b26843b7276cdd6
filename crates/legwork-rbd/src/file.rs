//! Reading a file whole, for every reader of files: up to a size, and text without a byte order mark.

use std::fs::{File, FileType};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use encoding_rs::{Encoding, UTF_8};
use thiserror::Error;

/// The most that a text may hold which says what is simulated [bytes].
pub const TEXT: u64 = 32_000_000;

/// The most that a mesh, or another file that a robot's file names, may hold [bytes].
pub const MESH: u64 = 500_000_000;

/// Why a file is not read, in words that follow its name.
#[derive(Debug, Error)]
pub enum Unread {
    /// The operating system refuses.
    #[error("{}", in_words(.0))]
    Io(#[from] io::Error),
    /// It is a folder.
    #[error("is a folder, expected a file")]
    Folder,
    /// It is neither a file nor what a command writes to a pipe.
    #[error("is {0}; valid is a file, or a command's output as the shell's <(command)")]
    Special(&'static str),
    /// It holds more than it may, or does not end.
    #[error("holds more than {}; that is the most that is read", megabytes(*.0))]
    TooLarge(u64),
    /// It is no text.
    #[error("not UTF-8 text: {0}")]
    NoText(String),
}

impl Unread {
    /// Whether it is no file that can be read, as opposed to one with bad content.
    pub fn is_io(&self) -> bool {
        !matches!(self, Self::TooLarge(_) | Self::NoText(_))
    }
}

/// The bytes of the file, which may be a pipe that ends.
///
/// # Errors
/// It cannot be read, is a device or the like, or holds more than `most` bytes.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, Unread> {
    // Before it is opened: that alone would wait for the writer of a pipe, or rewind a tape.
    let found = path.metadata()?;
    refuse(found.file_type(), path)?;
    let too_large = || Unread::TooLarge(most);
    if found.len() > most {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large()) } else { Ok(bytes) }
}

/// The text of the file, without a byte order mark.
///
/// # Errors
/// As [`read`], or it is no UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String, Unread> {
    text(read(path, most)?)
}

/// The text of an XML file, in the encoding that its byte order mark or its declaration tells.
///
/// # Errors
/// As [`read`], or it is no text in that encoding.
pub fn read_xml(path: &Path, most: u64) -> Result<String, Unread> {
    let bytes = read(path, most)?;
    let marked = Encoding::for_bom(&bytes).map(|(encoding, _)| encoding);
    match marked.or_else(|| declared(&bytes)).filter(|encoding| *encoding != UTF_8) {
        None => text(bytes),
        Some(encoding) => match encoding.decode(&bytes) {
            (text, _, false) => Ok(text.into_owned()),
            (.., true) => {
                Err(Unread::NoText(format!("found bytes that {} has not, which it declares", encoding.name())))
            }
        },
    }
}

/// The encoding that an XML declaration names.
fn declared(bytes: &[u8]) -> Option<&'static Encoding> {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1000)]);
    let declaration = &head[head.find("<?xml")?..];
    let declaration = &declaration[..declaration.find("?>")?];
    let value = declaration.split_once("encoding")?.1.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    Encoding::for_label(value[1..].split(quote).next()?.as_bytes())
}

/// The text that the bytes are, without a byte order mark.
///
/// # Errors
/// It is no UTF-8; says where, or what it is instead.
pub fn text(mut bytes: Vec<u8>) -> Result<String, Unread> {
    let is_utf_16 = match bytes[..] {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        [first, second, ..] => bytes.len().is_multiple_of(2) && (first == 0) != (second == 0),
        _ => false,
    };
    if is_utf_16 {
        return Err(Unread::NoText("found UTF-16; save it as UTF-8".to_owned()));
    }
    if bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
        bytes.drain(..3);
    }
    String::from_utf8(bytes).map_err(|error| {
        let bytes = error.as_bytes();
        let at = error.utf8_error().valid_up_to();
        let line = 1 + bytes[..at].iter().filter(|byte| **byte == b'\n').count();
        let before = bytes[..at].rsplit(|byte| *byte == b'\n').next().unwrap_or_default();
        let column = 1 + String::from_utf8_lossy(before).chars().count();
        Unread::NoText(format!("found the byte 0x{:02x} in line {line}, column {column}", bytes[at]))
    })
}

/// Where the lines of a text begin.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Of those after the first.
    begins: Vec<usize>,
}

impl Lines {
    /// Those of `text`.
    pub fn of(text: &str) -> Self {
        Self { begins: text.match_indices('\n').map(|(at, _)| at + 1).collect() }
    }

    /// The line, from one, of the byte at `offset`.
    pub fn line(&self, offset: usize) -> usize {
        1 + self.begins.partition_point(|begin| *begin <= offset)
    }
}

/// Refuses what may have no end, or never begin.
#[cfg_attr(not(unix), expect(unused_variables, reason = "pipes with names are of Unix"))]
fn refuse(kind: FileType, path: &Path) -> Result<(), Unread> {
    if kind.is_file() {
        return Ok(());
    }
    if kind.is_dir() {
        return Err(Unread::Folder);
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        // A pipe with a name may have no writer, now or ever; those of a shell are in these folders and have one.
        if kind.is_fifo() && (path.starts_with("/dev") || path.starts_with("/proc")) {
            return Ok(());
        }
        if kind.is_fifo() {
            return Err(Unread::Special("a named pipe"));
        }
    }
    Err(Unread::Special("a device"))
}

fn in_words(error: &io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "no such file or folder".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        ErrorKind::IsADirectory => "is a folder, expected a file".to_owned(),
        _ => format!("cannot be read: {error}"),
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes as f64 / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(bytes: &[u8]) -> String {
        text(bytes.to_vec()).expect_err("no UTF-8").to_string()
    }

    #[test]
    fn a_byte_order_mark_is_no_text() {
        assert_eq!(text("\u{feff}a = 1".into()).expect("text"), "a = 1");
        assert_eq!(text("\u{feff}".into()).expect("text"), "");
        assert_eq!(text("a\u{feff}".into()).expect("text"), "a\u{feff}");
    }

    #[test]
    fn what_the_system_refuses_is_said_in_words() {
        assert_eq!(in_words(&ErrorKind::NotFound.into()), "no such file or folder");
        assert_eq!(in_words(&ErrorKind::PermissionDenied.into()), "permission denied");
        assert_eq!(in_words(&ErrorKind::IsADirectory.into()), "is a folder, expected a file");
        assert_eq!(in_words(&io::Error::other("the disk is on fire")), "cannot be read: the disk is on fire");
    }

    #[test]
    fn what_is_no_text_is_said_with_its_place() {
        assert_eq!(
            refusal("a = 1\nä = \"".as_bytes().iter().chain(b"\xe4\"").copied().collect::<Vec<_>>().as_slice()),
            "not UTF-8 text: found the byte 0xe4 in line 2, column 6"
        );
        assert_eq!(refusal(b"\xff"), "not UTF-8 text: found the byte 0xff in line 1, column 1");
        for bytes in [&b"\xff\xfea\0"[..], b"\xfe\xff\0a", b"a\0=\0", b"\0a\0="] {
            assert_eq!(refusal(bytes), "not UTF-8 text: found UTF-16; save it as UTF-8");
        }
    }

    #[test]
    fn a_byte_is_in_the_line_that_the_breaks_before_it_make() {
        let text = "a\n\nb\r\nc";
        let lines = Lines::of(text);
        for offset in 0..10 {
            let breaks = text.bytes().take(offset).filter(|byte| *byte == b'\n').count();
            assert_eq!(lines.line(offset), 1 + breaks, "{offset}");
        }
    }

    #[test]
    fn a_file_may_hold_as_much_as_is_said() {
        let path = std::env::temp_dir().join(format!("legwork-largest-{}", std::process::id()));
        std::fs::write(&path, [b'a'; 10]).expect("a folder for such files");
        assert_eq!(read(&path, 10).expect("all of it"), [b'a'; 10]);
        let refused = read(&path, 9).expect_err("one byte too many");
        std::fs::remove_file(&path).expect("it is there");
        assert_eq!(refused.to_string(), "holds more than 0.000009 MB; that is the most that is read");
        assert!(!refused.is_io());
    }

    /// Its length is told as zero, as that of a pipe.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_file_that_does_not_tell_its_length_is_refused_where_it_is_too_long() {
        let path = Path::new("/proc/version");
        let all = read(path, 10_000).expect("less than that");
        assert_eq!(path.metadata().expect("it is there").len(), 0);
        let length = all.len() as u64;
        assert_eq!(read(path, length).expect("all of it"), all);
        assert!(matches!(read(path, length - 1), Err(Unread::TooLarge(most)) if most == length - 1));
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_no_file() {
        let refused = read(Path::new("/dev/zero"), 10).expect_err("it has no end");
        assert_eq!(
            refused.to_string(),
            "is a device; valid is a file, or a command's output as the shell's <(command)"
        );
        assert!(refused.is_io());
    }
}
