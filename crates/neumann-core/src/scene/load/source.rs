//! Where the bytes come from: files beside the scene, data URIs, memory.
//!
//! A scene may only read regular files within its own folder, and none that are hidden there or
//! in hidden folders (also after symbolic links are followed): keys and histories of a person
//! are such files. `allow_outside` lifts the folder, `allow_hidden` the names, nothing else.
//! Every resource is read once and enters the content hash in order of reference.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use super::LoadOptions;
use super::error::{Fault, quoted};
use super::uri::Uri;
use crate::decode::DecodeError;
use crate::memory::{self, Share};

/// Larger files are refused.
pub(super) const LARGEST_FILE: u64 = 4 << 30;

/// All files of a scene together may not be larger.
const LARGEST_SCENE: u64 = 8 << 30;

/// Bytes shared by all who refer to them.
pub(super) type Bytes = Arc<Vec<u8>>;

/// Yields the bytes of a relative URI of a scene in memory.
pub(super) type Resolve<'a> = &'a dyn Fn(&str) -> Option<Vec<u8>>;

/// Where relative URIs lead.
enum Place<'a> {
    /// A folder, canonical.
    Folder(PathBuf),
    /// Memory.
    Memory(Resolve<'a>),
}

/// Which paths are refused.
#[derive(Clone, Copy, Debug, Default)]
struct Limits {
    allow_outside: bool,
    allow_hidden: bool,
}

/// Fetches what the scene refers to.
pub(super) struct Source<'a> {
    place: Place<'a>,
    limits: Limits,
    fetched: BTreeMap<PathBuf, Bytes>,
    n_bytes: u64,
    hash: u64,
    /// Pays for what has been fetched, as long as the scene is read.
    memory: Share,
}

impl<'a> Source<'a> {
    /// A scene file on disk, whose bytes have been read already.
    pub(super) fn beside(path: &Path, bytes: &[u8], options: &LoadOptions) -> Result<Self, Fault> {
        let folder = match path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let folder = fs::canonicalize(folder)
            .map_err(|error| unreadable("", &format!("its folder cannot be found ({error})")))?;
        let mut source = Self::new(Place::Folder(folder), bytes);
        source.limits = Limits {
            allow_outside: options.allow_outside,
            allow_hidden: options.allow_hidden,
        };
        Ok(source)
    }

    /// A scene in memory.
    pub(super) fn memory(bytes: &[u8], resolve: Resolve<'a>) -> Self {
        Self::new(Place::Memory(resolve), bytes)
    }

    fn new(place: Place<'a>, bytes: &[u8]) -> Self {
        Self {
            place,
            limits: Limits::default(),
            fetched: BTreeMap::new(),
            n_bytes: bytes.len() as u64,
            hash: fnv1a(FNV_OFFSET, bytes),
            memory: Share::default(),
        }
    }

    /// FNV-1a over everything read so far.
    pub(super) fn content_hash(&self) -> u64 {
        self.hash
    }

    /// The files read so far.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        match self.place {
            Place::Folder(_) => self.fetched.keys().cloned().collect(),
            Place::Memory(_) => Vec::new(),
        }
    }

    /// The bytes that a URI stands for; `field` is where the URI is written.
    pub(super) fn fetch(&mut self, uri: &str, field: &str) -> Result<Bytes, Fault> {
        match Uri::parse(uri) {
            // Hashed with the file itself.
            Uri::Data(bytes) => {
                let paid = self.memory.grow(bytes.len() as u64);
                paid.map_err(|shortage| Fault::short(field, "its data", shortage))?;
                Ok(Arc::new(bytes))
            }
            Uri::Relative(path) => self.fetch_relative(&path, field),
            Uri::Foreign => Err(Fault::new(
                field,
                format!("{} is not a relative path", quoted(uri)),
                "only files beside the scene are read; copy the file there and name it so",
            )),
            Uri::Broken => Err(Fault::broken(
                field,
                format!("{} is not a valid URI", quoted(uri)),
            )),
        }
    }

    fn fetch_relative(&mut self, path: &str, field: &str) -> Result<Bytes, Fault> {
        let key = match &self.place {
            Place::Memory(_) => PathBuf::from(path),
            Place::Folder(folder) => resolve_in_folder(folder, path, self.limits, field)?,
        };
        if let Some(bytes) = self.fetched.get(&key) {
            return Ok(Arc::clone(bytes));
        }
        let left = LARGEST_SCENE.saturating_sub(self.n_bytes);
        let bytes = match &self.place {
            Place::Memory(resolve) => {
                check_path(path, self.limits, field)?;
                resolve(path)
                    .ok_or_else(|| unreadable(field, &format!("{} does not exist", quoted(path))))?
            }
            Place::Folder(_) => read_regular_file(&key, left, &mut self.memory)
                .map_err(|error| Fault::undecoded(field, &quoted(path), error, UNREADABLE))?,
        };
        self.n_bytes += bytes.len() as u64;
        self.hash = fnv1a(self.hash, &bytes);
        let bytes = Arc::new(bytes);
        self.fetched.insert(key, Arc::clone(&bytes));
        Ok(bytes)
    }
}

/// Reads a whole file, if it is one: no folder, no device, no pipe; `memory` pays for it.
///
/// The problem, if any, continues a sentence that begins with the file's name.
pub(super) fn read_regular_file(
    path: &Path,
    largest: u64,
    memory: &mut Share,
) -> Result<Vec<u8>, DecodeError> {
    let largest = largest.min(LARGEST_FILE);
    // Opening a pipe would wait for a writer, so the kind is asked first.
    let describe =
        |error: std::io::Error| DecodeError::Content(format!("cannot be read ({error})"));
    let check = |metadata: &fs::Metadata| {
        if !metadata.is_file() {
            Err(DecodeError::Content("is not a regular file".to_owned()))
        } else if metadata.len() > largest {
            Err(DecodeError::Content(format!(
                "has {} bytes; at most {largest} are read",
                metadata.len()
            )))
        } else {
            Ok(())
        }
    };
    check(&fs::metadata(path).map_err(describe)?)?;
    let file = File::open(path).map_err(describe)?;
    let metadata = file.metadata().map_err(describe)?;
    check(&metadata)?;
    memory.grow(metadata.len())?;
    let mut bytes = memory::empty(usize::try_from(metadata.len()).unwrap_or(usize::MAX))?;
    // Should it grow meanwhile, the rest is left.
    file.take(metadata.len())
        .read_to_end(&mut bytes)
        .map_err(describe)?;
    Ok(bytes)
}

/// The canonical path of a file that the scene may read.
fn resolve_in_folder(
    folder: &Path,
    path: &str,
    limits: Limits,
    field: &str,
) -> Result<PathBuf, Fault> {
    check_path(path, limits, field)?;
    let mut found = fs::canonicalize(folder.join(path));
    if found.is_err() && path.contains('\\') {
        found = fs::canonicalize(folder.join(path.replace('\\', "/")));
    }
    let found = found.map_err(|error| {
        unreadable(
            field,
            &format!("{} cannot be found ({error})", quoted(path)),
        )
    })?;
    if !limits.allow_outside && !found.starts_with(folder) {
        return Err(outside(path, field));
    }
    // What a link leads to may be hidden as well; the folders that the scene itself is in may.
    let n_common = found
        .components()
        .zip(folder.components())
        .take_while(|(found, folder)| found == folder)
        .count();
    if !limits.allow_hidden && found.components().skip(n_common).any(is_hidden) {
        return Err(hidden(path, field));
    }
    Ok(found)
}

/// True for a name that begins with a point.
fn is_hidden(component: Component<'_>) -> bool {
    match component {
        Component::Normal(name) => name.as_encoded_bytes().starts_with(b"."),
        _ => false,
    }
}

/// Refuses absolute paths, paths whose `..` lead out of the folder, and hidden names.
fn check_path(path: &str, limits: Limits, field: &str) -> Result<(), Fault> {
    if path.is_empty() || path.contains('\0') {
        return Err(Fault::broken(
            field,
            format!("{} is not a file name", quoted(path)),
        ));
    }
    // Some exporters write Windows separators; they must not lead out either.
    let path_with_slashes = path.replace('\\', "/");
    let mut depth = 0_i64;
    for component in Path::new(&path_with_slashes).components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir => depth -= 1,
            Component::RootDir | Component::Prefix(_) => {
                return Err(Fault::new(
                    field,
                    format!("{} is an absolute path", quoted(path)),
                    "copy the file beside the scene and name it by a relative path",
                ));
            }
        }
        if depth < 0 && !limits.allow_outside {
            return Err(outside(path, field));
        }
        if is_hidden(component) && !limits.allow_hidden {
            return Err(hidden(path, field));
        }
    }
    Ok(())
}

fn outside(path: &str, field: &str) -> Fault {
    Fault::new(
        field,
        format!("{} lies outside of the scene's folder", quoted(path)),
        "copy the file into the folder, or allow such paths with --allow-outside",
    )
}

fn hidden(path: &str, field: &str) -> Fault {
    Fault::new(
        field,
        format!("{} is hidden, or lies in a hidden folder", quoted(path)),
        "give it a name that does not begin with a point, or allow such names with --allow-hidden",
    )
}

fn unreadable(field: &str, problem: &str) -> Fault {
    Fault::new(field, problem, UNREADABLE)
}

/// Advice for files that cannot be read.
const UNREADABLE: &str = "check that the file is there and may be read";

const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;

/// Fowler–Noll–Vo 1a, 64 bits, going on from `hash`.
fn fnv1a(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{FNV_OFFSET, LoadOptions, Source, fnv1a};

    #[test]
    fn fnv_is_the_published_one() {
        assert_eq!(fnv1a(FNV_OFFSET, b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(FNV_OFFSET, b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn resources_are_hashed_once_in_order() {
        let resolve = |uri: &str| Some(uri.as_bytes().to_vec());
        let mut source = Source::memory(b"foo", &resolve);
        for uri in ["b", "a", "b", "data:,zzz", "%61"] {
            source.fetch(uri, "f").unwrap();
        }
        assert_eq!(source.content_hash(), fnv1a(FNV_OFFSET, b"fooba"));
    }

    #[test]
    fn nothing_outside_of_the_folder_is_read() {
        let root = std::env::temp_dir().join(format!("neumann-source-{}", std::process::id()));
        let folder = root.join("scene");
        fs::create_dir_all(folder.join("sub")).unwrap();
        fs::write(root.join("secret"), b"secret").unwrap();
        fs::write(folder.join("own file"), b"own").unwrap();
        let scene = folder.join("a.gltf");
        let mut inside = Source::beside(&scene, b"", &LoadOptions::default()).unwrap();
        let options = LoadOptions {
            allow_outside: true,
            ..LoadOptions::default()
        };
        let mut free = Source::beside(&scene, b"", &options).unwrap();

        assert_eq!(*inside.fetch("own%20file", "f").unwrap(), b"own");
        assert_eq!(*inside.fetch("./sub/../own file", "f").unwrap(), b"own");
        assert_eq!(*inside.fetch("sub\\..\\own file", "f").unwrap(), b"own");
        for uri in [
            "../secret",
            "%2e%2e/secret",
            "sub/../../secret",
            "..\\secret",
        ] {
            let fault = inside.fetch(uri, "f").unwrap_err();
            assert!(fault.problem.contains("outside"), "{uri}: {fault:?}");
            assert_eq!(*free.fetch(uri, "f").unwrap(), b"secret");
        }
        let secret = root.join("secret");
        for uri in [
            secret.to_str().unwrap(),
            "file:///etc/hostname",
            "http://localhost/x",
            "/dev/zero",
            "sub",
            "missing",
            "",
            ".",
            "%00",
        ] {
            assert!(inside.fetch(uri, "f").is_err(), "{uri}");
            assert!(free.fetch(uri, "f").is_err(), "{uri}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&secret, folder.join("link")).unwrap();
            std::os::unix::fs::symlink("/dev/zero", folder.join("zero")).unwrap();
            assert!(inside.fetch("link", "f").is_err());
            assert_eq!(*free.fetch("link", "f").unwrap(), b"secret");
            assert!(free.fetch("zero", "f").is_err());
        }
        fs::remove_dir_all(root).unwrap();
    }

    #[test]
    fn hidden_files_are_read_only_if_that_is_allowed() {
        let root = std::env::temp_dir().join(format!("neumann-hidden-{}", std::process::id()));
        // The folders of the scene itself may be hidden.
        let folder = root.join(".cache/scene");
        fs::create_dir_all(folder.join(".ssh")).unwrap();
        fs::create_dir_all(folder.join("sub/.git")).unwrap();
        let files = [
            ".ssh/key",
            "sub/.git/config",
            ".env",
            "..dots",
            "open.bin",
            "a.b",
        ];
        for name in files {
            fs::write(folder.join(name), name).unwrap();
        }
        fs::write(root.join(".cache/beside"), "beside").unwrap();
        fs::write(root.join(".secret"), "secret").unwrap();
        let scene = folder.join("a.gltf");
        let source = |allow_outside, allow_hidden| {
            let options = LoadOptions {
                allow_outside,
                allow_hidden,
                ..LoadOptions::default()
            };
            Source::beside(&scene, b"", &options).unwrap()
        };
        let (mut inside, mut free) = (source(false, false), source(false, true));
        for uri in [
            ".ssh/key",
            "%2essh/key",
            ".ssh\\key",
            "./.ssh/key",
            "sub/.git/config",
            "sub/../.env",
            "..dots",
        ] {
            let fault = inside.fetch(uri, "f").unwrap_err();
            assert!(fault.problem.contains("hidden"), "{uri}: {fault:?}");
            assert!(free.fetch(uri, "f").is_ok(), "{uri}");
        }
        for uri in ["open.bin", "./open.bin", "sub/../a.b"] {
            assert!(inside.fetch(uri, "f").is_ok(), "{uri}");
        }
        let mut outside = source(true, false);
        assert!(outside.fetch("../beside", "f").is_ok());
        assert!(outside.fetch("../../.secret", "f").is_err());
        assert!(source(true, true).fetch("../../.secret", "f").is_ok());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(".ssh/key", folder.join("link")).unwrap();
            assert!(inside.fetch("link", "f").is_err());
            assert!(free.fetch("link", "f").is_ok());
        }
        assert_eq!(inside.files().len(), 2, "each once");
        fs::remove_dir_all(root).unwrap();
    }
}
