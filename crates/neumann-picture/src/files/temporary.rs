//! A file on its way: it has no name until it is whole, where the system can do that.
//!
//! On Linux a file is opened without a name (`O_TMPFILE`), so that nothing is left of it if the
//! program is killed. Elsewhere, and on file systems that cannot, it is called
//! `.NAME.PROCESS-NUMBER.tmp`, and holds a lock while somebody works on it: whoever writes the
//! same file next removes those that nobody holds any more.
//!
//! A file that has further names (hard links), or an owner that we cannot give it again, is not
//! replaced but overwritten, after the new content has been stored beside it as
//! `.NAME.PROCESS-NUMBER.whole`. If the program is killed between, the next writer does the rest.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

use super::destination::{Destination, folder_of};

/// A file that is not yet where it belongs.
pub(super) struct Temporary {
    file: File,
    /// Its present name, if it has one; removed at the end.
    name: Option<PathBuf>,
    target: PathBuf,
}

impl Temporary {
    /// Opens one in the folder of the file that it is to become.
    pub(super) fn beside(target: &Path) -> io::Result<Self> {
        let unfinished = |file, name| Self {
            file,
            name,
            target: target.to_owned(),
        };
        if let Some(file) = without_name(folder_of(target)) {
            return Ok(unfinished(file, None));
        }
        loop {
            let name = fresh_name(target, "tmp");
            let created = OpenOptions::new()
                .read(true)
                .write(true)
                .create_new(true)
                .open(&name);
            match created {
                Ok(file) => {
                    let made = unfinished(file, Some(name));
                    if made.hold() {
                        return Ok(made);
                    }
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// The file, to be written to.
    pub(super) fn file(&self) -> &File {
        &self.file
    }

    /// Finds out whether there is room for more than nothing.
    pub(super) fn reserve(&self) -> io::Result<()> {
        #[cfg(target_os = "linux")]
        {
            use rustix::fs::{FallocateFlags, fallocate};
            use rustix::io::Errno;
            let reserved = fallocate(&self.file, FallocateFlags::empty(), 0, 1 << 16);
            if let Err(error @ (Errno::NOSPC | Errno::DQUOT)) = reserved {
                return Err(error.into());
            }
        }
        Ok(())
    }

    /// Locks the file; false if somebody took it for a leftover and removed it before that.
    fn hold(&self) -> bool {
        // Where there are no locks nobody removes anything.
        let _ = self.file.try_lock();
        has_name(&self.file)
    }

    /// Puts the file where it belongs.
    pub(super) fn take_place(mut self, destination: &Destination) -> io::Result<()> {
        if self.take_over_from(destination)? {
            let name = self.named("tmp")?;
            fs::rename(&name, &self.target)?;
            self.name = None;
        } else {
            self.named("whole")?;
            sync_folder(&self.target);
            let mut present = OpenOptions::new().write(true).open(&self.target)?;
            if let Err(error) = overwrite(&mut present, &mut self.file) {
                // The next writer will do the rest.
                self.name = None;
                return Err(error);
            }
        }
        sync_folder(&self.target);
        Ok(())
    }

    /// Gives the file the mode and the owner of the present one; false if it cannot stand in
    /// for it.
    #[cfg(unix)]
    fn take_over_from(&self, destination: &Destination) -> io::Result<bool> {
        use std::os::unix::fs::{MetadataExt, fchown};

        let Some(present) = &destination.present else {
            return Ok(true);
        };
        let ours = self.file.metadata()?;
        if present.nlink() > 1 {
            return Ok(false);
        }
        let is_same_owner = (ours.uid(), ours.gid()) == (present.uid(), present.gid());
        if !is_same_owner && fchown(&self.file, Some(present.uid()), Some(present.gid())).is_err() {
            return Ok(false);
        }
        self.file.set_permissions(present.permissions())?;
        Ok(true)
    }

    #[cfg(not(unix))]
    fn take_over_from(&self, destination: &Destination) -> io::Result<bool> {
        if let Some(present) = &destination.present {
            self.file.set_permissions(present.permissions())?;
        }
        Ok(true)
    }

    /// Gives the file a name of the given kind in its folder.
    fn named(&mut self, kind: &str) -> io::Result<PathBuf> {
        loop {
            let name = fresh_name(&self.target, kind);
            let linked = match &self.name {
                Some(present) => fs::rename(present, &name),
                None => {
                    // Before it has a name, so that nobody takes it for a leftover.
                    let _ = self.file.try_lock();
                    link(&self.file, &name)
                }
            };
            match linked {
                Ok(()) => {
                    self.name = Some(name.clone());
                    return Ok(name);
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(name) = &self.name {
            // Nothing more can be done about a file that cannot be removed.
            let _ = fs::remove_file(name);
        }
    }
}

/// A file in that folder that has no name.
#[cfg(target_os = "linux")]
fn without_name(folder: &Path) -> Option<File> {
    use rustix::fs::{Mode, OFlags, open};

    // Without it the file could not be given a name.
    if !Path::new("/proc/self/fd").is_dir() {
        return None;
    }
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let mode = Mode::from_raw_mode(0o666);
    open(folder, flags, mode).ok().map(File::from)
}

#[cfg(not(target_os = "linux"))]
fn without_name(_folder: &Path) -> Option<File> {
    None
}

/// Gives a file without a name one.
#[cfg(target_os = "linux")]
fn link(file: &File, name: &Path) -> io::Result<()> {
    use std::os::fd::AsRawFd;

    use rustix::fs::{AtFlags, CWD, linkat};

    let itself = format!("/proc/self/fd/{}", file.as_raw_fd());
    Ok(linkat(CWD, itself, CWD, name, AtFlags::SYMLINK_FOLLOW)?)
}

#[cfg(not(target_os = "linux"))]
fn link(_file: &File, _name: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Writes the content of the one file over that of the other.
fn overwrite(present: &mut File, content: &mut File) -> io::Result<()> {
    content.rewind()?;
    let n_bytes = io::copy(content, present)?;
    present.set_len(n_bytes)?;
    present.sync_all()
}

/// Makes a new name durable; where a system cannot, the file is still whole.
fn sync_folder(target: &Path) {
    if let Ok(folder) = File::open(folder_of(target)) {
        let _ = folder.sync_all();
    }
}

/// Bytes of a name that temporary names of it begin with; a name may have 255 in all.
const LONGEST_STEM: usize = 200;

/// What temporary names of a file begin with; `None` for the second part if it was cut short.
fn stem(target: &Path) -> (String, bool) {
    let name = target.file_name().unwrap_or_default();
    let mut text = name.to_string_lossy().into_owned();
    let mut is_whole = name.to_str().is_some();
    while text.len() > LONGEST_STEM {
        text.pop();
        is_whole = false;
    }
    (format!(".{text}."), is_whole)
}

fn fresh_name(target: &Path, kind: &str) -> PathBuf {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let number = COUNTER.fetch_add(1, Ordering::Relaxed);
    let (stem, _) = stem(target);
    target.with_file_name(format!("{stem}{}-{number}.{kind}", std::process::id()))
}

/// Removes what killed runs have left of this file, and does what they have left to do.
#[cfg(unix)]
pub(super) fn clear_leftovers(target: &Path) {
    use std::os::unix::fs::{MetadataExt, OpenOptionsExt};

    use rustix::fs::OFlags;

    let Ok(entries) = fs::read_dir(folder_of(target)) else {
        return;
    };
    let (stem, is_whole_stem) = stem(target);
    let us = rustix::process::geteuid().as_raw();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(kind) = name.to_str().and_then(|name| leftover_kind(name, &stem)) else {
            continue;
        };
        let path = entry.path();
        let opened = OpenOptions::new()
            .read(true)
            .custom_flags((OFlags::NOFOLLOW | OFlags::NONBLOCK).bits().cast_signed())
            .open(&path);
        let Ok(mut file) = opened else { continue };
        let is_ours = file
            .metadata()
            .is_ok_and(|found| found.is_file() && found.uid() == us);
        // A lock means that somebody is at work.
        if !is_ours || file.try_lock().is_err() || !has_name(&file) {
            continue;
        }
        if kind == Leftover::Whole {
            if !is_whole_stem {
                continue;
            }
            let present = OpenOptions::new().write(true).open(target);
            if !present.is_ok_and(|mut present| overwrite(&mut present, &mut file).is_ok()) {
                continue;
            }
        }
        let _ = fs::remove_file(path);
    }
}

/// Temporary files may be in use elsewhere, and cannot be told from those that are not.
#[cfg(not(unix))]
pub(super) fn clear_leftovers(_target: &Path) {}

#[derive(Clone, Copy, PartialEq, Eq)]
#[cfg(unix)]
enum Leftover {
    /// Begun.
    Part,
    /// Complete, and to be written over the target.
    Whole,
}

/// What a name is, if it is one of ours: `STEM.PROCESS-NUMBER.KIND`.
#[cfg(unix)]
fn leftover_kind(name: &str, stem: &str) -> Option<Leftover> {
    let (numbers, kind) = name.strip_prefix(stem)?.rsplit_once('.')?;
    let (process, number) = numbers.split_once('-')?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if !is_number(process) || !is_number(number) {
        return None;
    }
    match kind {
        "tmp" => Some(Leftover::Part),
        "whole" => Some(Leftover::Whole),
        _ => None,
    }
}

#[cfg(unix)]
fn has_name(file: &File) -> bool {
    use std::os::unix::fs::MetadataExt;
    file.metadata().is_ok_and(|found| found.nlink() > 0)
}

#[cfg(not(unix))]
fn has_name(_file: &File) -> bool {
    true
}
