//! Joining the folders of shards.

use std::path::{Path, PathBuf};

use super::{Damaged, Found, Store, Survey};
use legwork::error::Error;

/// Copies the chunks in `folders` that are sound into the folder `into`, which may be one of them, new, or what an
/// earlier merge left. Returns what is missing after that, and the damaged chunks that were found on the way.
///
/// # Errors
/// A folder holds no study or another one than the first; a chunk is different in two folders; another run writes to
/// `into`; a folder cannot be read or written.
pub fn merge(folders: &[PathBuf], into: &Path) -> Result<Survey, Error> {
    let mut sources: Vec<Store> = folders.iter().map(|folder| Store::read(folder)).collect::<Result<_, _>>()?;
    let Some(first) = sources.first() else {
        return Err(Error::invalid("merge", "no folder is given, expected those of the shards"));
    };
    let name = first.folder.display().to_string();
    for other in &sources {
        first.manifest.require_same(&other.manifest, &name, &other.folder)?;
    }
    let into = Store::open_with(into, first.manifest.clone(), first.size, None, |_| None)?;
    sources.retain(|source| !same_folder(&source.folder, &into.folder));
    let mut survey = Survey::default();
    for chunk in 0..into.number_of_chunks() {
        if !join(chunk, &sources, &into, &mut survey.damaged)? {
            survey.missing.push(chunk);
        }
    }
    Ok(survey)
}

/// Whether `into` has a sound chunk after this.
fn join(chunk: u64, sources: &[Store], into: &Store, damaged: &mut Vec<Damaged>) -> Result<bool, Error> {
    let mut kept: Option<(PathBuf, Vec<u8>)> = None;
    for store in std::iter::once(into).chain(sources) {
        let path = store.chunk_path(chunk);
        match (store.find(chunk)?, &kept) {
            (Found::Nothing, _) => {}
            (Found::Damaged(problem), _) => damaged.push(Damaged { chunk, path, problem }),
            (Found::Sound(bytes), None) => kept = Some((path, bytes)),
            (Found::Sound(bytes), Some((_, same))) if bytes == *same => {}
            (Found::Sound(_), Some((other, _))) => {
                let problem = format!(
                    "differs from {}, though both are whole and of the same study; \
                     delete the one that you do not trust",
                    other.display()
                );
                return Err(Error::invalid(path.display().to_string(), problem));
            }
        }
    }
    let Some((path, bytes)) = kept else {
        return Ok(false);
    };
    if path != into.chunk_path(chunk) {
        into.write_bytes(chunk, &bytes)?;
    }
    Ok(true)
}

fn same_folder(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
