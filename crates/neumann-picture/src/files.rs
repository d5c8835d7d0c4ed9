//! Writes files whole or not at all.
//!
//! The content goes to a temporary name in the same folder, is flushed to the
//! disk, and takes the place of the old file in one step: whatever happens in
//! between, the name holds either the old content or the new.

use std::error::Error;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::PictureError;

/// What a writer may fail with: an error of the system, or of an encoder.
pub type WriteError = Box<dyn Error + Send + Sync>;

/// Writes a file whole or not at all.
///
/// # Errors
/// If the place cannot be written to, or `write` fails; the old file is then still
/// there and the temporary one is gone.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), WriteError>,
) -> Result<(), PictureError> {
    let target = real_target(path)?;
    let (temporary, file) = create_beside(&target, path)?;
    let guard = RemoveOnDrop(&temporary);
    let result = fill(file, write);
    result.map_err(|error| match error.downcast::<io::Error>() {
        Ok(error) => PictureError::io(path, "write", *error),
        Err(error) => match error.downcast::<PictureError>() {
            Ok(error) => *error,
            Err(error) => PictureError::content(path, format!("cannot write: {error}")),
        },
    })?;
    fs::rename(&temporary, &target).map_err(|e| PictureError::io(path, "write", e))?;
    std::mem::forget(guard);
    sync_folder(&target);
    Ok(())
}

/// Finds out, before any work is done, whether a file could be written there.
///
/// # Errors
/// If the folder does not exist or cannot be written to, or something other than
/// a file has the name.
pub fn check_destination(path: &Path) -> Result<(), PictureError> {
    let target = real_target(path)?;
    let (temporary, _) = create_beside(&target, path)?;
    drop(RemoveOnDrop(&temporary));
    Ok(())
}

/// Follows links, so that the file they lead to is replaced and not the link; refuses
/// to put a file in the place of a folder or a device.
fn real_target(path: &Path) -> Result<PathBuf, PictureError> {
    let Some(name) = path.file_name() else {
        return Err(PictureError::destination(path, "not the name of a file"));
    };
    match fs::metadata(path) {
        Ok(metadata) if metadata.is_dir() => Err(PictureError::destination(
            path,
            "is a folder; name a file in it",
        )),
        Ok(metadata) if !metadata.is_file() => Err(PictureError::destination(
            path,
            "is a device or pipe; name an ordinary file",
        )),
        Ok(_) => fs::canonicalize(path).map_err(|e| PictureError::io(path, "write", e)),
        Err(_) => {
            let folder = match path.parent() {
                Some(parent) if !parent.as_os_str().is_empty() => parent,
                _ => Path::new("."),
            };
            if !folder.is_dir() {
                return Err(PictureError::destination(
                    path,
                    format!(
                        "the folder {} does not exist; make it first",
                        folder.display()
                    ),
                ));
            }
            Ok(folder.join(name))
        }
    }
}

fn create_beside(target: &Path, path: &Path) -> Result<(PathBuf, File), PictureError> {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let stem: String = target
        .file_name()
        .map(|name| name.to_string_lossy().chars().take(40).collect())
        .unwrap_or_default();
    loop {
        let number = COUNTER.fetch_add(1, Ordering::Relaxed);
        let name = format!(".{stem}.{}-{number}.tmp", std::process::id());
        let temporary = target.with_file_name(name);
        let created = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&temporary);
        match created {
            Ok(file) => return Ok((temporary, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(PictureError::io(path, "write", error)),
        }
    }
}

fn fill(
    file: File,
    write: impl FnOnce(&mut BufWriter<File>) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    write(&mut writer)?;
    writer.flush()?;
    writer.get_ref().sync_all()?;
    Ok(())
}

/// Makes the new name itself durable; where a system cannot, the file is still whole.
fn sync_folder(target: &Path) {
    if let Some(folder) = target.parent().and_then(|p| File::open(p).ok()) {
        let _ = folder.sync_all();
    }
}

struct RemoveOnDrop<'a>(&'a Path);

impl Drop for RemoveOnDrop<'_> {
    fn drop(&mut self) {
        // Nothing more can be done about a file that cannot be removed.
        let _ = fs::remove_file(self.0);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::fs;
    use std::io::Write;
    use std::path::{Path, PathBuf};
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::{check_destination, write_atomically};

    /// A folder of its own, removed at the end.
    pub(crate) struct TestFolder(PathBuf);

    impl TestFolder {
        pub(crate) fn new() -> Self {
            static COUNTER: AtomicU32 = AtomicU32::new(0);
            let n = COUNTER.fetch_add(1, Ordering::Relaxed);
            let name = format!("neumann-picture-test-{}-{n}", std::process::id());
            let path = std::env::temp_dir().join(name);
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        pub(crate) fn join(&self, name: &str) -> PathBuf {
            self.0.join(name)
        }

        fn names(&self) -> Vec<String> {
            let mut names: Vec<_> = fs::read_dir(&self.0)
                .unwrap()
                .map(|e| e.unwrap().file_name().into_string().unwrap())
                .collect();
            names.sort();
            names
        }
    }

    impl Drop for TestFolder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = TestFolder::new();
        let path = folder.join("a.txt");
        write_atomically(&path, |w| Ok(w.write_all(b"old")?)).unwrap();
        let error = write_atomically(&path, |w| {
            w.write_all(b"half of the new")?;
            Err("the encoder gave up".into())
        })
        .unwrap_err();
        assert!(error.to_string().contains("a.txt"), "{error}");
        assert!(error.to_string().contains("gave up"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(folder.names(), ["a.txt"]);
        write_atomically(&path, |w| Ok(w.write_all(b"new")?)).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(folder.names(), ["a.txt"]);
    }

    #[test]
    fn bad_places_are_found_before_any_work() {
        let folder = TestFolder::new();
        let error = check_destination(&folder.join("no/such/a.exr")).unwrap_err();
        assert!(error.to_string().contains("does not exist"), "{error}");
        let error = check_destination(&folder.join("")).unwrap_err();
        assert!(error.to_string().contains("folder"), "{error}");
        assert!(check_destination(Path::new("/")).is_err());
        check_destination(&folder.join("a.exr")).unwrap();
        assert!(folder.names().is_empty(), "the check leaves nothing");
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_not_replaced_and_links_are_followed() {
        assert!(check_destination(Path::new("/dev/null")).is_err());
        let folder = TestFolder::new();
        fs::write(folder.join("real"), b"1").unwrap();
        std::os::unix::fs::symlink(folder.join("real"), folder.join("link")).unwrap();
        write_atomically(&folder.join("link"), |w| Ok(w.write_all(b"2")?)).unwrap();
        assert_eq!(fs::read(folder.join("real")).unwrap(), b"2");
        assert!(
            fs::symlink_metadata(folder.join("link"))
                .unwrap()
                .is_symlink()
        );
    }
}
