//! What the regions of a file are called: a chunk of the root, which a reader may skip.

use super::bytes::{Reader, push_varint};
use super::crc32;
use super::index::{FLAGS_AT, HEADER_BYTES, Index, NAMES};
use crate::error::{Error, Result};
use std::collections::BTreeMap;

/// In the header's flags: the root has the chunk. It spares those who do not need names to look for them.
const HAS_NAMES: u8 = 1;

/// Bytes of a name at most: it is shown, and spoken, in one line.
pub const MAX_NAME: usize = 1000;

/// What regions are called, by their colour in the file: straight sRGB and alpha. Regions of one colour
/// are one class, and share its name.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Names(BTreeMap<[u8; 4], String>);

impl Names {
    /// Gives a colour a name, in place of the one that it had.
    ///
    /// # Errors
    /// [`Error::Usage`] for a name without any letters, of several lines, or of more than [`MAX_NAME`]
    /// bytes.
    pub fn insert(&mut self, color: [u8; 4], name: &str) -> Result<()> {
        if !is_fine(name) {
            return Err(Error::Usage(format!(
                "a name is one line of up to {MAX_NAME} bytes, and “{}” is not",
                name.escape_debug().take(40).collect::<String>()
            )));
        }
        self.0.insert(color, name.into());
        Ok(())
    }

    /// The name of a colour.
    pub fn get(&self, color: [u8; 4]) -> Option<&str> {
        self.0.get(&color).map(String::as_str)
    }

    /// Colours and names, in the order of the colours' bytes.
    pub fn iter(&self) -> impl Iterator<Item = ([u8; 4], &str)> {
        self.0.iter().map(|(&color, name)| (color, name.as_str()))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Bytes that they take in a file.
    pub fn bytes_in_file(&self) -> u64 {
        let mut chunk = Vec::new();
        if !self.is_empty() {
            push_chunk(&mut chunk, NAMES, &self.to_bytes());
        }
        chunk.len() as u64
    }

    fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        push_varint(&mut out, self.0.len() as u32);
        for (color, name) in self.iter() {
            out.extend(color);
            push_varint(&mut out, name.len() as u32);
            out.extend(name.as_bytes());
        }
        out
    }
}

/// Whether a name can be shown in a line.
fn is_fine(name: &str) -> bool {
    !name.trim().is_empty() && name.len() <= MAX_NAME && !name.chars().any(char::is_control)
}

/// Reads the names in a file.
///
/// # Errors
/// [`Error::Malformed`] where they are damaged.
pub fn names(index: &Index) -> Result<Names> {
    let mut chunks = index.chunks().iter().filter(|chunk| chunk.tag == NAMES);
    let Some(chunk) = chunks.next() else { return Ok(Names::default()) };
    let mut from = Reader::new("names", &chunk.bytes);
    if chunks.next().is_some() {
        return Err(from.error("they are there twice"));
    }
    let mut names = BTreeMap::new();
    for _ in 0..from.count(color_and_length())? {
        let color = from.array()?;
        let length = from.varint()? as usize;
        let name = str::from_utf8(from.take(length)?).ok().filter(|name| is_fine(name));
        let name = name.ok_or_else(|| from.error("one is not a line of text"))?;
        if names.last_key_value().is_some_and(|(&last, _)| last >= color) {
            return Err(from.error("they are not in order"));
        }
        names.insert(color, name.to_string());
    }
    from.finish()?;
    Ok(Names(names))
}

/// The least that a name takes beside its letters.
fn color_and_length() -> usize {
    size_of::<[u8; 4]>() + 1
}

/// The head of a file with these names in place of those that it had, if any. What follows the head stays as
/// it is.
///
/// # Errors
/// [`Error::Malformed`] for what is no head, [`Error::Limit`] where it would exceed 4 GB.
pub(super) fn renamed(head: &[u8], names: &Names) -> Result<Vec<u8>> {
    let short = || Error::malformed("head", "it ends too early");
    let (header, root) = head.split_at_checked(HEADER_BYTES).ok_or_else(short)?;
    let mut from = Reader::new("head", root);
    let regions = from.varint()?;
    let mut kept = Vec::new();
    let mut count = 0;
    for _ in 0..from.varint()? {
        let tag: [u8; 4] = from.array()?;
        let length = from.varint()?;
        let bytes = from.take(length as usize)?;
        if tag != NAMES {
            push_chunk(&mut kept, tag, bytes);
            count += 1;
        }
    }
    if !names.is_empty() {
        push_chunk(&mut kept, NAMES, &names.to_bytes());
        count += 1;
    }
    let mut root = Vec::new();
    push_varint(&mut root, regions);
    push_varint(&mut root, count);
    root.extend(kept);
    root.extend(from.rest());

    let mut out = header[..HEADER_BYTES - 8].to_vec();
    out[FLAGS_AT] = out[FLAGS_AT] & !HAS_NAMES | if names.is_empty() { 0 } else { HAS_NAMES };
    let length = u32::try_from(root.len());
    let too_long = |_| Error::Limit("the head would exceed 4 GB: take fewer names".into());
    out.extend(length.map_err(too_long)?.to_le_bytes());
    let crc = crc32(&[&out[..], &root].concat());
    out.extend(crc.to_le_bytes());
    out.extend(root);
    Ok(out)
}

fn push_chunk(out: &mut Vec<u8>, tag: [u8; 4], bytes: &[u8]) {
    out.extend(tag);
    push_varint(out, bytes.len() as u32);
    out.extend(bytes);
}

/// A file with these names in place of those that it had, if any.
///
/// ```
/// # use istar::{EncodeOptions, Limits, container, labels::Source};
/// # let source = Source::from_labels([2, 1], vec![1, 2], &Limits::default())?;
/// # let file = istar::encode_lossless(&source, &EncodeOptions::default())?;
/// let mut names = container::Names::default();
/// names.insert(source.color(1), "Arctic Ocean")?;
/// let named = container::with_names(&file, &names)?;
/// let index = container::Index::of_whole(&named, &Limits::default())?;
/// assert_eq!(container::names(&index)?, names);
/// # Ok::<(), istar::Error>(())
/// ```
///
/// # Errors
/// Those of [`Index::of_whole`]; [`Error::Limit`] where the head would exceed 4 GB.
pub fn with_names(file: &[u8], names: &Names) -> Result<Vec<u8>> {
    let end = head_bytes(file)?;
    let mut out = renamed(&file[..end], names)?;
    out.extend(&file[end..]);
    Ok(out)
}

/// Bytes of the head of a file that is there as a whole.
fn head_bytes(file: &[u8]) -> Result<usize> {
    Index::of_whole(file, &crate::limits::Limits::default())?;
    let length = &file[HEADER_BYTES - 8..HEADER_BYTES - 4];
    Ok(HEADER_BYTES + u32::from_le_bytes([length[0], length[1], length[2], length[3]]) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::labels::Source;
    use crate::limits::Limits;

    const RED: [u8; 4] = [255, 0, 0, 255];
    const BLUE: [u8; 4] = [0, 0, 255, 255];

    fn file() -> Vec<u8> {
        let classes = [RED, BLUE].map(u32::from_le_bytes);
        let source = Source::from_labels([2, 1], classes.to_vec(), &Limits::default()).unwrap();
        crate::encode_lossless(&source, &Default::default()).unwrap()
    }

    fn names_of(list: &[([u8; 4], &str)]) -> Names {
        let mut names = Names::default();
        list.iter().for_each(|(color, name)| names.insert(*color, name).unwrap());
        names
    }

    fn read(file: &[u8]) -> Result<Names> {
        names(&Index::of_whole(file, &Limits::default())?)
    }

    #[test]
    fn names_are_set_and_replaced_and_taken_away_and_nothing_else_changes() {
        let plain = file();
        assert_eq!(read(&plain), Ok(Names::default()));
        let first = names_of(&[(RED, "Österreich"), (BLUE, "L’Océan")]);
        let named = with_names(&plain, &first).unwrap();
        assert_eq!((read(&named), named[FLAGS_AT]), (Ok(first), HAS_NAMES));
        let second = names_of(&[(BLUE, "sea")]);
        let renamed = with_names(&named, &second).unwrap();
        assert_eq!(read(&renamed), Ok(second));
        assert_eq!(with_names(&renamed, &Names::default()).unwrap(), plain);
        let options = Limits::default();
        assert_eq!(crate::open(&named, &options), crate::open(&plain, &options));
    }

    #[test]
    fn what_is_no_name_is_refused() {
        let mut names = Names::default();
        for bad in ["", "  ", "two\nlines", "a\u{7}", &"x".repeat(MAX_NAME + 1)] {
            assert!(matches!(names.insert(RED, bad), Err(Error::Usage(_))), "{bad}");
        }
        assert!(names.is_empty());
    }

    #[test]
    fn damaged_names_are_an_error() {
        let chunk = |bytes: &[u8]| {
            let plain = file();
            let end = head_bytes(&plain).unwrap();
            // As `renamed` puts it together.
            let good = renamed(&plain[..end], &names_of(&[(RED, "a"), (BLUE, "b")])).unwrap();
            let at = good.windows(4).position(|tag| tag == NAMES).unwrap() + 5;
            let mut root = good[HEADER_BYTES..at - 1].to_vec();
            root.push(bytes.len() as u8);
            root.extend(bytes);
            root.extend(&good[at + usize::from(good[at - 1])..]);
            let mut out = good[..HEADER_BYTES - 8].to_vec();
            out.extend((root.len() as u32).to_le_bytes());
            let crc = crc32(&[&out[..], &root].concat());
            out.extend(crc.to_le_bytes());
            out.extend(root);
            out.extend(&plain[end..]);
            read(&out).map(|names| names.len())
        };
        assert_eq!(chunk(&[1, 0, 0, 255, 255, 1, b'b']), Ok(1));
        let bad: [&[u8]; 6] = [
            &[],
            &[9, 0, 0, 255, 255, 1, b'b'],
            &[1, 0, 0, 255, 255, 2, b'b'],
            &[1, 0, 0, 255, 255, 1, 0xff],
            &[1, 0, 0, 255, 255, 1, b'b', 7],
            &[2, 9, 0, 0, 255, 1, b'a', 9, 0, 0, 255, 1, b'b'],
        ];
        for bytes in bad {
            assert!(matches!(chunk(bytes), Err(Error::Malformed { .. })), "{bytes:?}");
        }
    }
}
