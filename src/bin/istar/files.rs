//! Files in and out. Output appears whole or not at all.

use istar::{Image, Limits};
use std::fs;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::Path;

/// Reads a whole file.
pub fn read(path: &Path) -> Result<Vec<u8>, String> {
    fs::read(path).map_err(|error| format!("{}: {}", path.display(), reason(&error)))
}

/// Reads an `.istar` file to be drawn.
pub fn read_image(path: &Path) -> Result<(Image, Vec<u8>), String> {
    read_by(istar::open, path)
}

/// Reads an `.istar` file to be taken at its own size: one without loss is just what it was made from.
pub fn read_exact(path: &Path) -> Result<(Image, Vec<u8>), String> {
    read_by(istar::open_exact, path)
}

type Open = fn(&[u8], &Limits) -> istar::Result<Image>;

fn read_by(open: Open, path: &Path) -> Result<(Image, Vec<u8>), String> {
    let bytes = read(path)?;
    let image = open(&bytes, &Limits::default()).map_err(|error| at(path, &error))?;
    Ok((image, bytes))
}

/// An error with the file that it is about.
pub fn at(path: &Path, error: &dyn std::fmt::Display) -> String {
    format!("{}: {error}", path.display())
}

/// An output file that takes the place of `path` only once it is whole: it is written beside it
/// under another name and renamed.
pub struct Output<'a> {
    path: &'a Path,
    file: tempfile::NamedTempFile,
}

impl<'a> Output<'a> {
    /// Opens it at once, so that a place that cannot be written is told before any work.
    pub fn create(path: &'a Path) -> Result<Self, String> {
        let fault = |error| format!("cannot write {}: {}", path.display(), reason(&error));
        if path.is_dir() {
            return Err(format!("cannot write {}: it is a folder", path.display()));
        }
        let file = tempfile::Builder::new()
            .prefix(".istar-")
            .suffix(".part")
            .tempfile_in(folder(path))
            .map_err(fault)?;
        Ok(Output { path, file })
    }

    /// A nameless file on the same disk, for what is put together later.
    pub fn spool(&self) -> Result<fs::File, String> {
        let folder = folder(self.path);
        tempfile::tempfile_in(folder)
            .map_err(|error| format!("cannot write in {}: {}", folder.display(), reason(&error)))
    }

    /// Writes `bytes` and puts the file in its place.
    pub fn finish(self, bytes: &[u8]) -> Result<(), String> {
        self.finish_with(|file| file.write_all(bytes))
    }

    /// Has the file written and puts it in its place.
    pub fn finish_with(
        self,
        write: impl FnOnce(&mut BufWriter<&fs::File>) -> io::Result<()>,
    ) -> Result<(), String> {
        let path = self.path;
        let fault = |error| format!("cannot write {}: {}", path.display(), reason(&error));
        let mut buffered = BufWriter::new(self.file.as_file());
        write(&mut buffered).and_then(|()| buffered.flush()).map_err(fault)?;
        drop(buffered);
        self.file.as_file().sync_all().map_err(fault)?;
        share_like_any_new_file(self.file.as_file()).map_err(fault)?;
        self.file.persist(path).map_err(|error| fault(error.error))?;
        Ok(())
    }
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Temporary files are private; the finished one is not.
#[cfg(unix)]
fn share_like_any_new_file(file: &fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn share_like_any_new_file(_: &fs::File) -> std::io::Result<()> {
    Ok(())
}

/// Why reading or writing failed.
pub fn reason(error: &std::io::Error) -> String {
    match error.kind() {
        ErrorKind::NotFound => "there is no such file or folder".into(),
        ErrorKind::PermissionDenied => "permission denied".into(),
        ErrorKind::IsADirectory => "it is a folder".into(),
        ErrorKind::StorageFull => "the disk is full".into(),
        _ => error.to_string(),
    }
}
