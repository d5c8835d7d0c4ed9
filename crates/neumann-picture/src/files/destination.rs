//! Where a file is to go, and what can be known about it before any work is done.

use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

use crate::PictureError;

/// More links one after the other are taken for a circle, as the system does.
const MOST_LINKS: usize = 40;

/// The place that a name leads to.
pub(super) struct Destination {
    /// The file that is written: links are followed, also those that lead to nothing yet.
    pub(super) target: PathBuf,
    /// What is there now.
    pub(super) present: Option<Metadata>,
}

impl Destination {
    /// Follows links, so that the file they lead to is replaced and not the link; refuses
    /// to put a file in the place of a folder or a device.
    pub(super) fn of(path: &Path) -> Result<Self, PictureError> {
        let refused = |what: &str| PictureError::destination(path, what);
        if path.file_name().is_none() {
            return Err(refused("not the name of a file"));
        }
        match fs::metadata(path) {
            Ok(present) if present.is_dir() => Err(refused("is a folder; name a file in it")),
            Ok(present) if !present.is_file() => {
                Err(refused("is a device or pipe; name an ordinary file"))
            }
            Ok(present) => Ok(Self {
                target: fs::canonicalize(path).map_err(|e| PictureError::io(path, "write", e))?,
                present: Some(present),
            }),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Self {
                target: Self::of_nothing_yet(path)?,
                present: None,
            }),
            Err(error) if error.kind() == std::io::ErrorKind::InvalidFilename => {
                Err(refused("the name is too long; choose a shorter one"))
            }
            Err(error) => Err(PictureError::io(path, "write", error)),
        }
    }

    /// The place of a name where nothing is, or a link to nothing.
    fn of_nothing_yet(path: &Path) -> Result<PathBuf, PictureError> {
        let mut place = path.to_owned();
        for _ in 0..MOST_LINKS {
            let folder = folder_of(&place).to_owned();
            match fs::read_link(&place) {
                Ok(next) => place = folder.join(next),
                Err(_) if !folder.is_dir() => {
                    return Err(PictureError::destination(
                        path,
                        format!(
                            "the folder {} does not exist; make it first",
                            folder.display()
                        ),
                    ));
                }
                Err(_) => return Ok(place),
            }
        }
        Err(PictureError::destination(
            path,
            "is a link that leads to itself; remove it",
        ))
    }

    /// Whether the new file may take the place of the present one.
    pub(super) fn check(&self, path: &Path) -> Result<(), PictureError> {
        match self.obstacle() {
            Some(what) => Err(PictureError::destination(path, what)),
            None => Ok(()),
        }
    }

    #[cfg(not(unix))]
    fn obstacle(&self) -> Option<String> {
        let present = self.present.as_ref()?;
        let is_read_only = present.permissions().readonly();
        is_read_only.then(|| "is read-only; make it writable or name another file".to_owned())
    }

    #[cfg(unix)]
    fn obstacle(&self) -> Option<String> {
        use std::os::unix::fs::MetadataExt;

        use rustix::fs::{Access, access};
        use rustix::process::geteuid;

        let folder = folder_of(&self.target);
        if let Some(what) = immutability(folder) {
            let folder = folder.display();
            return Some(format!(
                "its folder {folder} is {what}; use chattr, or choose another one"
            ));
        }
        let present = self.present.as_ref()?;
        if let Some(what) = immutability(&self.target) {
            return Some(format!("is {what}; use chattr, or name another file"));
        }
        if access(&self.target, Access::WRITE_OK).is_err() {
            return Some("is read-only; make it writable or name another file".to_owned());
        }
        let folder = fs::metadata(folder).ok()?;
        let us = geteuid().as_raw();
        let is_sticky = folder.mode() & 0o1000 != 0;
        if is_sticky && us != 0 && us != present.uid() && us != folder.uid() {
            return Some(
                "belongs to somebody else, and in its folder only owners replace their files; \
                 name another file"
                    .to_owned(),
            );
        }
        None
    }
}

/// The folder of a file, `.` for a bare name.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Says so if the file system was told that this may not be changed.
#[cfg(target_os = "linux")]
fn immutability(path: &Path) -> Option<&'static str> {
    use rustix::fs::{AtFlags, CWD, StatxAttributes, StatxFlags, statx};

    let found = statx(CWD, path, AtFlags::empty(), StatxFlags::BASIC_STATS).ok()?;
    let attributes = found.stx_attributes;
    if attributes.contains(StatxAttributes::IMMUTABLE) {
        Some("immutable")
    } else if attributes.contains(StatxAttributes::APPEND) {
        Some("append-only")
    } else {
        None
    }
}

/// Unknown elsewhere; writing will tell.
#[cfg(all(unix, not(target_os = "linux")))]
fn immutability(_path: &Path) -> Option<&'static str> {
    None
}
