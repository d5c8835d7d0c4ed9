//! Writes files whole or not at all.
//!
//! The content goes to a file without a name in the same folder (`temporary`), is flushed to
//! the disk, and takes the place of the old file in one step: whatever happens in between, the
//! name holds either the old content or the new. Mode and owner of the old file are kept, links
//! are followed, and whatever can be known to be in the way is found before any work is done
//! (`destination`).

mod destination;
mod temporary;

use std::error::Error;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use self::destination::{Destination, folder_of};
use self::temporary::{Temporary, clear_leftovers};
use crate::PictureError;

/// What a writer may fail with: an error of the system, or of an encoder.
pub type WriteError = Box<dyn Error + Send + Sync>;

/// Writes a file whole or not at all.
///
/// # Errors
/// If the place cannot be written to, or `write` fails; the old file is then still there.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), WriteError>,
) -> Result<(), PictureError> {
    let destination = Destination::of(path)?;
    clear_leftovers(&destination.target);
    let io_error = |error| PictureError::io(path, "write", error);
    let temporary = Temporary::beside(&destination.target).map_err(io_error)?;
    fill(temporary.file(), write).map_err(|error| match error.downcast::<io::Error>() {
        Ok(error) => io_error(*error),
        Err(error) => match error.downcast::<PictureError>() {
            Ok(error) => *error,
            Err(error) => PictureError::content(path, format!("cannot write: {error}")),
        },
    })?;
    temporary.take_place(&destination).map_err(io_error)
}

/// Finds out, before any work is done, whether a file could be written there.
///
/// # Errors
/// If the folder does not exist or cannot be written to, something other than a file has the
/// name, or the file there may not be replaced.
pub fn check_destination(path: &Path) -> Result<(), PictureError> {
    let destination = Destination::of(path)?;
    destination.check(path)?;
    clear_leftovers(&destination.target);
    Temporary::beside(&destination.target)
        .and_then(|temporary| temporary.reserve())
        .map_err(|error| PictureError::io(path, "write", error))
}

/// Memory that a film takes while it is rendered and written: two films in turn, and the planes of
/// a file, three floats a pixel each; features beside them.
#[must_use]
pub fn film_bytes(width: usize, height: usize, n_layers: usize) -> u64 {
    let n_layers = n_layers as u64 + 1;
    let planes = 2 * (n_layers + 2) + (n_layers + 3) + 5;
    (width as u64 * height as u64).saturating_mul(planes * 12)
}

/// Finds out whether a file of so many bytes has room there; a place that cannot say has.
///
/// # Errors
/// If the file system has less space left.
#[cfg_attr(not(unix), expect(unused_variables, reason = "nobody is asked there"))]
pub fn check_space(path: &Path, n_bytes: u64) -> Result<(), PictureError> {
    #[cfg(unix)]
    {
        let destination = Destination::of(path)?;
        let Ok(found) = rustix::fs::statvfs(folder_of(&destination.target)) else {
            return Ok(());
        };
        let left = found.f_bavail.saturating_mul(found.f_frsize);
        if left < n_bytes {
            return Err(PictureError::destination(
                path,
                format!(
                    "needs {:.0} MB or more, but {:.0} MB are left there; free some space or \
                     choose another place",
                    n_bytes as f64 * 1e-6,
                    left as f64 * 1e-6
                ),
            ));
        }
    }
    Ok(())
}

/// True if both names lead to one file, by links, hard links or another spelling, or would once
/// it is there.
#[must_use]
pub fn is_same_place(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        #[cfg(unix)]
        (Ok(a), Ok(b)) => {
            use std::os::unix::fs::MetadataExt;
            (a.dev(), a.ino()) == (b.dev(), b.ino())
        }
        #[cfg(not(unix))]
        (Ok(_), Ok(_)) => fs::canonicalize(a).ok() == fs::canonicalize(b).ok(),
        (Err(_), Err(_)) => {
            let place = |path: &Path| {
                let target = Destination::of(path).ok()?.target;
                let folder = fs::canonicalize(folder_of(&target)).ok()?;
                Some(folder.join(target.file_name()?))
            };
            place(a).is_some_and(|a| Some(a) == place(b))
        }
        _ => false,
    }
}

fn fill(
    file: &File,
    write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    let mut writer = BufWriter::with_capacity(1 << 18, file);
    write(&mut writer)?;
    writer.flush()?;
    file.sync_all()?;
    Ok(())
}

#[cfg(test)]
pub(crate) mod tests {
    use std::fs;
    use std::io::Write;
    use std::path::{Path, PathBuf};
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::{check_destination, check_space, is_same_place, write_atomically};

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

    #[test]
    fn the_name_must_fit_and_there_must_be_room() {
        let folder = TestFolder::new();
        let error = check_destination(&folder.join(&"a".repeat(300))).unwrap_err();
        assert!(error.to_string().contains("too long"), "{error}");
        check_destination(&folder.join(&"a".repeat(255))).unwrap();
        write_atomically(&folder.join(&"a".repeat(255)), |w| Ok(w.write_all(b"1")?)).unwrap();
        check_space(&folder.join("b"), 1).unwrap();
        #[cfg(unix)]
        assert!(check_space(&folder.join("b"), u64::MAX).is_err());
    }

    #[test]
    fn one_file_by_two_names_is_told() {
        let folder = TestFolder::new();
        fs::write(folder.join("a"), b"1").unwrap();
        fs::write(folder.join("b"), b"1").unwrap();
        fs::create_dir(folder.join("sub")).unwrap();
        fs::hard_link(folder.join("a"), folder.join("c")).unwrap();
        let is_same = |a: &str, b: &str| is_same_place(&folder.join(a), &folder.join(b));
        assert!(is_same("a", "a") && is_same("a", "sub/../a"));
        assert!(is_same("new", "sub/../new") && !is_same("new", "newer"));
        assert!(!is_same("a", "b") && !is_same("a", "new"));
        #[cfg(unix)]
        {
            assert!(is_same("a", "c"));
            std::os::unix::fs::symlink("new", folder.join("to-new")).unwrap();
            assert!(is_same("to-new", "new"));
        }
    }

    #[cfg(unix)]
    #[test]
    fn mode_links_and_further_names_survive() {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

        let folder = TestFolder::new();
        let write = |name: &str, text: &str| {
            write_atomically(&folder.join(name), |w| Ok(w.write_all(text.as_bytes())?)).unwrap();
        };
        write("a", "old");
        let mode = |name: &str| fs::metadata(folder.join(name)).unwrap().mode() & 0o7777;
        fs::set_permissions(folder.join("a"), fs::Permissions::from_mode(0o640)).unwrap();
        write("a", "new");
        assert_eq!(mode("a"), 0o640);
        // A further name still names the same file.
        fs::hard_link(folder.join("a"), folder.join("further")).unwrap();
        write("a", "short");
        write("a", "longer than before");
        assert_eq!(
            fs::read(folder.join("further")).unwrap(),
            b"longer than before"
        );
        write("further", "2");
        assert_eq!(fs::read(folder.join("a")).unwrap(), b"2");
        // A link to nothing makes what it leads to.
        symlink("made", folder.join("link")).unwrap();
        check_destination(&folder.join("link")).unwrap();
        write("link", "3");
        assert_eq!(fs::read(folder.join("made")).unwrap(), b"3");
        symlink("round", folder.join("round")).unwrap();
        assert!(check_destination(&folder.join("round")).is_err());
        assert_eq!(folder.names(), ["a", "further", "link", "made", "round"]);
    }

    #[cfg(unix)]
    #[test]
    fn what_killed_runs_left_is_cleared_and_finished() {
        let folder = TestFolder::new();
        fs::write(folder.join("a.exr"), b"half written over").unwrap();
        fs::write(folder.join(".a.exr.1-0.tmp"), b"begun").unwrap();
        fs::write(folder.join(".a.exr.1-1.whole"), b"whole").unwrap();
        // Neither are these of ours, nor of this file.
        let others = [".a.exr.swp", ".a.exr.x-0.tmp", ".b.exr.1-0.tmp"];
        for name in others {
            fs::write(folder.join(name), b"other").unwrap();
        }
        // Somebody is at work on this one.
        let held = fs::File::create(folder.join(".a.exr.2-0.tmp")).unwrap();
        held.lock().unwrap();
        check_destination(&folder.join("a.exr")).unwrap();
        assert_eq!(fs::read(folder.join("a.exr")).unwrap(), b"whole");
        let mut expected = vec![".a.exr.2-0.tmp", "a.exr"];
        expected.extend(others);
        expected.sort_unstable();
        assert_eq!(folder.names(), expected);
    }

    #[cfg(unix)]
    #[test]
    fn read_only_and_immutable_files_are_refused() {
        use std::os::unix::fs::PermissionsExt;

        let folder = TestFolder::new();
        let path = folder.join("a");
        fs::write(&path, b"1").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        if !rustix::process::geteuid().is_root() {
            let error = check_destination(&path).unwrap_err().to_string();
            assert!(error.contains("read-only"), "{error}");
        }
        let chattr = |flag: &str| {
            let status = std::process::Command::new("chattr")
                .args([flag.as_ref(), path.as_os_str()])
                .stderr(std::process::Stdio::null())
                .status();
            status.is_ok_and(|status| status.success())
        };
        // Only root may do this, and only on some file systems.
        if chattr("+i") {
            let error = check_destination(&path).unwrap_err().to_string();
            chattr("-i");
            assert!(error.contains("immutable"), "{error}");
        }
    }
}
