//! The folder of a study and the work that fills it: same bytes however it is done, and nothing lost or mixed.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::thread::sleep;
use std::time::Duration;

use legwork::error::Error;
use legwork_study::parallel::{self, Progress};
use legwork_study::store::{self, Shard, Store};
use serde::{Deserialize, Serialize};

const STUDY: &str = "rollouts = 1000\nseed = 1\n";
const IDENTITY: u128 = 42;
/// Chunks of 8, the last of 4.
const TOTAL: u64 = 1012;
const CHUNKS: u64 = 127;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Record {
    index: u64,
    outcome: String,
    distance: Option<f64>,
}

fn record(index: u64) -> Record {
    let distance = (index as f64 + 0.1).sqrt();
    Record { index, outcome: "fell\n\"x\"".to_owned(), distance: (!index.is_multiple_of(3)).then_some(distance) }
}

/// A folder for the folders of a test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        // In memory where there is such a folder, since every chunk waits for the disk.
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() };
        let path = parent.join(format!("legwork-store-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn open(folder: &Path, shard: Option<&str>) -> Result<Store, Error> {
    Store::open(folder, STUDY, IDENTITY, TOTAL, shard.map(|shard| Shard::parse(shard).unwrap()))
}

/// Runs what is missing until `stop_after` records were computed.
fn run(folder: &Path, shard: Option<&str>, threads: usize, stop_after: u64) -> Progress {
    let store = open(folder, shard).unwrap();
    let survey = store.survey().unwrap();
    let computed = AtomicU64::new(0);
    let job = |index| {
        computed.fetch_add(1, Relaxed);
        Some(record(index))
    };
    let stop = || computed.load(Relaxed) >= stop_after;
    let work = || parallel::run_chunks(&store, &survey, job, |_| {}, stop);
    parallel::with_threads(Some(threads), work).unwrap().unwrap()
}

fn chunk(folder: &Path, chunk: u64) -> PathBuf {
    folder.join(format!("chunks/{chunk:06}.jsonl"))
}

/// The names and bytes of everything in the study but its locks.
fn bytes(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("study.toml".to_owned(), fs::read(folder.join("study.toml")).unwrap())];
    for entry in fs::read_dir(folder.join("chunks")).unwrap() {
        let path = entry.unwrap().path();
        files.push((path.file_name().unwrap().to_str().unwrap().to_owned(), fs::read(path).unwrap()));
    }
    files.sort();
    files
}

fn whole(folder: &Path) -> Vec<(String, Vec<u8>)> {
    assert_eq!(run(folder, None, 2, u64::MAX), Progress { done: TOTAL, total: TOTAL });
    bytes(folder)
}

#[track_caller]
fn says<T>(result: Result<T, Error>, words: &[&str]) -> Error {
    let error = result.err().expect("it is refused");
    for word in words {
        assert!(error.to_string().contains(word), "{word:?} is not in: {error}");
    }
    error
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let temp = Folder::new("threads");
    let expected = whole(&temp.path("two"));
    assert_eq!(expected.len() as u64, CHUNKS + 1);
    for threads in [1, 3] {
        let folder = temp.path(&threads.to_string());
        assert!(!run(&folder, None, threads, u64::MAX).is_stopped());
        assert!(bytes(&folder) == expected, "{threads}");
    }
    let records: Result<Vec<Record>, _> = Store::read(&temp.path("3")).unwrap().records().collect();
    assert!(records.unwrap().into_iter().eq((0..TOTAL).map(record)), "all, in order, to the bit");
}

#[test]
fn shards_in_any_order_in_one_folder_or_several_give_the_same_bytes() {
    let temp = Folder::new("shards");
    let expected = whole(&temp.path("whole"));
    let one = temp.path("one");
    for shard in ["3/3", "1/3", "2/3"] {
        assert!(!Store::open(&one, STUDY, IDENTITY, TOTAL, None).unwrap().is_complete().unwrap());
        assert!(!run(&one, Some(shard), 2, u64::MAX).is_stopped());
        run(&temp.path(&shard.replace('/', "-")), Some(shard), 1, u64::MAX);
    }
    assert!(open(&one, Some("2/3")).unwrap().is_complete().unwrap());
    assert!(bytes(&one) == expected);

    let (part, joined) = (temp.path("2-3"), temp.path("joined"));
    let survey = store::merge(&[part.clone(), temp.path("3-3")], &joined).unwrap();
    assert!(survey.missing.iter().copied().eq((0..CHUNKS).step_by(3)), "the first shard: {survey:?}");
    assert!(!Store::read(&joined).unwrap().is_complete().unwrap());
    assert_eq!(store::merge(&[temp.path("1-3")], &joined).unwrap(), store::Survey::default(), "goes on");
    assert!(bytes(&joined) == expected);

    let folders = ["1-3", "2-3", "3-3", "one"].map(|name| temp.path(name));
    assert_eq!(store::merge(&folders, &part).unwrap(), store::Survey::default(), "into one of them");
    assert!(bytes(&part) == expected);
}

#[test]
fn interruptions_anywhere_give_the_same_bytes() {
    let temp = Folder::new("interruptions");
    let expected = whole(&temp.path("whole"));
    for stop_after in [0, 1, 7, 8, 100, 500] {
        let folder = temp.path(&stop_after.to_string());
        let first = run(&folder, None, 2, stop_after);
        assert!(first.is_stopped() && first.done <= stop_after && first.total == TOTAL, "{first:?}");
        // Two chunks at most are begun and dropped.
        assert!(first.done + 2 * 8 >= stop_after, "{first:?} of {stop_after}");
        let kept = bytes(&folder);
        assert!(kept.iter().all(|file| expected.contains(file)), "what is kept is whole");
        let second = run(&folder, Some("1/2"), 3, 50);
        assert!(second.is_stopped());
        assert!(!run(&folder, None, 1, u64::MAX).is_stopped());
        assert!(bytes(&folder) == expected, "{stop_after}");
    }
}

#[test]
fn what_is_done_is_not_done_again() {
    let temp = Folder::new("resume");
    let done = run(&temp.path("a"), None, 2, 500).done;
    let store = open(&temp.path("a"), None).unwrap();
    let survey = store.survey().unwrap();
    let (computed, told) = (AtomicU64::new(0), AtomicU64::new(0));
    let job = |index| {
        computed.fetch_add(1, Relaxed);
        Some(record(index))
    };
    let progress = |records| {
        assert!(records > done, "{records}");
        told.fetch_max(records, Relaxed);
    };
    let all = parallel::run_chunks(&store, &survey, job, progress, || false).unwrap();
    assert_eq!(all, Progress { done: TOTAL, total: TOTAL });
    assert_eq!((computed.into_inner(), told.into_inner()), (TOTAL - done, TOTAL));
    assert!(done > 0);
}

#[test]
fn a_job_that_is_stopped_half_way_leaves_no_half_chunk() {
    let temp = Folder::new("half");
    let folder = temp.path("a");
    let store = open(&folder, None).unwrap();
    let job = |index| (index != 12).then(|| record(index));
    let progress = parallel::run_chunks(&store, &store.survey().unwrap(), job, |_| {}, || false).unwrap();
    assert_eq!(progress, Progress { done: TOTAL - 8, total: TOTAL });
    assert_eq!(store.survey().unwrap().missing, [1]);
    assert!(!chunk(&folder, 1).exists());
}

#[test]
fn damaged_swapped_and_foreign_chunks_are_found_told_and_redone() {
    let temp = Folder::new("damage");
    let folder = temp.path("a");
    let expected = whole(&folder);
    let other = temp.path("other");
    let store = Store::open(&other, "seed = 2\n", IDENTITY, TOTAL, None).unwrap();
    store.write(50, &store.range(50).map(record).collect::<Vec<_>>()).unwrap();
    let sound = fs::read(chunk(&folder, 10)).unwrap();
    fs::write(chunk(&folder, 10), &sound[..sound.len() / 2]).unwrap();
    let mut flipped = fs::read(chunk(&folder, 20)).unwrap();
    *flipped.last_mut().unwrap() ^= 1;
    fs::write(chunk(&folder, 20), flipped).unwrap();
    fs::write(chunk(&folder, 21), "").unwrap();
    fs::rename(chunk(&folder, 30), temp.path("swap")).unwrap();
    fs::rename(chunk(&folder, 31), chunk(&folder, 30)).unwrap();
    fs::rename(temp.path("swap"), chunk(&folder, 31)).unwrap();
    fs::remove_file(chunk(&folder, 40)).unwrap();
    fs::copy(chunk(&other, 50), chunk(&folder, 50)).unwrap();

    let survey = Store::read(&folder).unwrap().survey().unwrap();
    assert_eq!(survey.missing, [10, 20, 21, 30, 31, 40, 50]);
    let told: Vec<_> = survey.damaged.iter().map(|damaged| (damaged.chunk, damaged.problem.as_str())).collect();
    for (found, (number, words)) in told.iter().zip([
        (10, "cut short"),
        (20, "checksum"),
        (21, "cut short"),
        (30, "8 records from 248, expected 8 from 240"),
        (31, "8 records from 240, expected 8 from 248"),
        (50, "belongs to study"),
    ]) {
        assert!(found.0 == number && found.1.contains(words), "{told:?}");
    }
    assert!(told.len() == 6 && survey.damaged[1].path == chunk(&folder, 20));

    let store = Store::read(&folder).unwrap();
    let mut records = store.records::<Record>();
    assert!(records.by_ref().take(80).map(Result::unwrap).eq((0..80).map(record)), "up to the damage");
    says(records.next().unwrap(), &["000010.jsonl", "cut short", "run the study again"]);
    assert!(records.next().is_none(), "and nothing after it");

    // A merge takes no damaged chunk, and repairs what it joins into.
    let joined = temp.path("joined");
    assert_eq!(store::merge(std::slice::from_ref(&folder), &joined).unwrap(), survey);
    run(&joined, None, 2, u64::MAX);
    assert_eq!(store::merge(std::slice::from_ref(&joined), &folder).unwrap().missing, [0; 0]);
    assert!(bytes(&folder) == expected);

    fs::write(chunk(&folder, 3), "x").unwrap();
    assert!(whole(&folder) == expected, "redone");
}

#[test]
fn a_missing_chunk_stops_the_records_with_what_to_do() {
    let temp = Folder::new("missing");
    run(&temp.path("a"), Some("1/2"), 1, u64::MAX);
    let store = Store::read(&temp.path("a")).unwrap();
    let mut records = store.records::<Record>();
    assert_eq!(records.by_ref().take_while(Result::is_ok).count(), 8);
    let second = store.records::<Record>().nth(8).unwrap();
    says(second, &["000001.jsonl", "not there yet", "merge the shards"]);
    let other = store.records::<u64>().next().unwrap();
    says(other, &["000000.jsonl", "holds a record that cannot be read"]);
}

#[test]
fn what_a_crashed_run_left_half_written_is_ignored_and_removed() {
    let temp = Folder::new("crashed");
    let expected = whole(&temp.path("whole"));
    let folder = temp.path("a");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(".study.unfinished.toml"), "# half").unwrap();
    fs::write(folder.join(".lock"), "").unwrap();
    run(&folder, None, 1, 100);
    for number in [0, 1, 126] {
        fs::write(folder.join(format!("chunks/.{number:06}.unfinished.jsonl")), "{\"form").unwrap();
    }
    // The second shard clears its own away, not what another shard may be writing.
    drop(open(&folder, Some("2/2")).unwrap());
    let unfinished = |number: u64| folder.join(format!("chunks/.{number:06}.unfinished.jsonl")).exists();
    assert!(unfinished(0) && !unfinished(1) && unfinished(126));
    assert!(whole(&folder) == expected);
    assert!(!folder.join(".study.unfinished.toml").exists());
}

#[test]
fn a_second_run_into_a_folder_is_refused_while_the_first_is_there() {
    let temp = Folder::new("second");
    let folder = temp.path("a");
    let name = folder.display().to_string();
    let first = open(&folder, None).unwrap();
    for shard in [None, Some("1/2")] {
        let error = says(open(&folder, shard), &[&name, "another run", "choose another folder"]);
        assert!(error.is_io(), "nothing is wrong with what was asked");
    }
    says(store::merge(std::slice::from_ref(&folder), &folder), &["another run"]);
    assert!(Store::read(&folder).is_ok(), "reading needs no lock");
    drop(first);

    let one = open(&folder, Some("1/2")).unwrap();
    let two = open(&folder, Some("2/2")).unwrap();
    says(open(&folder, Some("2/2")), &["another run of shard 2/2"]);
    says(open(&folder, Some("2/3")), &["cuts the study otherwise than shard 2/3"]);
    says(open(&folder, None), &["another run"]);
    drop((one, two));
    open(&folder, Some("2/3")).unwrap();
    open(&folder, None).unwrap();
}

#[test]
fn the_folder_of_another_study_is_refused_and_left_alone() {
    let temp = Folder::new("another");
    let folder = temp.path("a");
    let expected = whole(&folder);
    let name = folder.display().to_string();
    let hash = format!("{:032x}", Store::read(&folder).unwrap().hash());
    for (text, identity, total, words) in [
        ("rollouts = 1000\nseed = 2\n", IDENTITY, TOTAL, "it says \"seed = 1\", not \"seed = 2\""),
        (STUDY, IDENTITY, 2 * TOTAL, "it has 1012 records, not 2024"),
        ("rollouts = 1000\n", IDENTITY, TOTAL, "more lines"),
        (STUDY, 43, TOTAL, "another version of the program, model or data"),
    ] {
        says(Store::open(&folder, text, identity, total, None), &[&name, &hash, words]);
        let other = temp.path("b");
        let _ = fs::remove_dir_all(&other);
        drop(Store::open(&other, text, identity, total, None).unwrap());
        says(store::merge(&[folder.clone(), other.clone()], &temp.path("c")), &["b: holds another study", &name]);
        says(store::merge(&[other], &folder), &["another study"]);
    }
    assert!(bytes(&folder) == expected && !temp.path("c").exists());

    fs::write(folder.join("study.toml"), STUDY).unwrap();
    says(open(&folder, None), &["study.toml", "changed or damaged"]);
    says(Store::read(&folder), &["study.toml", "changed or damaged"]);
}

#[test]
fn a_folder_of_other_files_is_refused_and_left_alone() {
    let temp = Folder::new("other-files");
    fs::write(temp.path("thesis.tex"), "").unwrap();
    says(open(&temp.0, None), &["thesis.tex", "no study", "new or empty folder"]);
    assert_eq!(fs::read_dir(&temp.0).unwrap().count(), 1, "not even a lock is left");
    says(Store::read(&temp.0), &["holds no study", "study.toml"]);
    says(Store::read(&temp.path("none")), &["none: no such file or folder"]);
    says(store::merge(&[], &temp.0), &["no folder is given"]);
    assert!(says(open(&temp.path("thesis.tex"), None), &["thesis.tex", "is a file, expected a folder"]).is_io());
}

#[test]
fn two_sound_chunks_that_differ_are_not_joined() {
    let temp = Folder::new("differ");
    let folders = ["a", "b"].map(|name| temp.path(name));
    for (folder, shift) in folders.iter().zip([0, 1]) {
        let store = open(folder, None).unwrap();
        store.write(0, &(0..8).map(|index| record(index + shift)).collect::<Vec<_>>()).unwrap();
    }
    let names = folders.clone().map(|folder| chunk(&folder, 0).display().to_string());
    says(store::merge(&folders, &temp.path("c")), &[&names[0], &names[1], "differs from"]);
}

/// `/dev/full` is a file of a disk that is always full.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_stops_the_others_names_the_file_and_keeps_what_is_done() {
    let temp = Folder::new("full");
    let expected = whole(&temp.path("whole"));
    let folder = temp.path("a");
    let store = open(&folder, None).unwrap();
    let begun = AtomicU64::new(0);
    std::os::unix::fs::symlink("/dev/full", folder.join("chunks/.000003.unfinished.jsonl")).unwrap();
    let job = |index| {
        begun.fetch_add(1, Relaxed);
        Some(record(index))
    };
    let survey = store.survey().unwrap();
    let work = || parallel::run_chunks(&store, &survey, job, |_| {}, || false);
    let failed = parallel::with_threads(Some(1), work).unwrap();
    assert!(says(failed, &["000003.jsonl", "No space left on device"]).is_io());
    assert_eq!(begun.into_inner(), 4 * 8, "nothing is begun after it");
    assert_eq!(store.survey().unwrap().missing, (3..CHUNKS).collect::<Vec<_>>());
    assert!(!folder.join("chunks/.000003.unfinished.jsonl").is_symlink(), "what was half written takes no room");
    drop(store);
    assert!(whole(&folder) == expected);
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_named_and_stays_readable() {
    use std::os::unix::fs::PermissionsExt;
    let temp = Folder::new("read-only");
    let folder = temp.path("a");
    let done = run(&folder, None, 1, 100).done;
    assert!(done > 0);
    // In place of the folder for chunks a file, which stops root too
    let store = open(&folder, None).unwrap();
    fs::rename(folder.join("chunks"), temp.path("chunks")).unwrap();
    fs::write(folder.join("chunks"), "").unwrap();
    let missing = store::Survey { missing: vec![126], damaged: vec![] };
    let failed = parallel::run_chunks(&store, &missing, |index| Some(record(index)), |_| {}, || false);
    assert!(says(failed, &["a/chunks/000126.jsonl", "Not a directory"]).is_io());
    drop(store);
    says(open(&folder, None), &["a/chunks"]);
    fs::remove_file(folder.join("chunks")).unwrap();
    fs::rename(temp.path("chunks"), folder.join("chunks")).unwrap();

    for path in [folder.join("chunks"), folder.clone()] {
        fs::set_permissions(path, fs::Permissions::from_mode(0o555)).unwrap();
    }
    let read = Store::read(&folder).unwrap();
    assert_eq!(read.records::<Record>().take_while(Result::is_ok).count() as u64, done);
    // Root may write in spite of it.
    if fs::write(folder.join("chunks/probe"), "").is_err() {
        let store = open(&folder, None).unwrap();
        let chunk = store.range(126).map(record).collect::<Vec<_>>();
        assert!(says(store.write(126, &chunk), &["a/chunks/000126.jsonl", "permission denied"]).is_io());
    }
    for path in [folder.clone(), folder.join("chunks")] {
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

#[test]
fn more_records_than_the_disk_holds_are_refused_at_once() {
    let temp = Folder::new("space");
    let many = Store::open(&temp.path("a"), STUDY, IDENTITY, u64::MAX / 2, None).unwrap();
    let name = temp.path("a").display().to_string();
    assert!(says(many.check_space(500, 0), &[&name, "the disk has", "free", "TB"]).is_io());
    // One chunk of 64 records takes a whole number of blocks.
    let free = fs4::available_space(&temp.0).unwrap();
    let total = 64 * (free / 2 / 4096);
    let half = Store::open(&temp.path("b"), STUDY, IDENTITY, total, None).unwrap();
    half.check_space(60, 0).unwrap();
    says(half.check_space(6000, 0), &["needs about"]);
    let shard = Shard::parse("2/1000").unwrap();
    drop(half);
    let part = Store::open(&temp.path("b"), STUDY, IDENTITY, total, Some(shard)).unwrap();
    part.check_space(6000, 0).unwrap();

    // What is done needs no more room, however little it took.
    let folder = temp.path("c");
    run(&folder, None, 2, u64::MAX);
    let free = fs4::available_space(&temp.0).unwrap();
    open(&folder, None).unwrap().check_space(free, 0).unwrap();
    says(open(&folder, None).unwrap().check_space(0, 2 * free), &["what is still to be written needs about"]);
    // 8 records are missing.
    fs::remove_file(chunk(&folder, 5)).unwrap();
    open(&folder, None).unwrap().check_space(free / 20, 0).unwrap();
    says(open(&folder, None).unwrap().check_space(free / 4, 0), &["needs about"]);
}

#[test]
fn memory_does_not_grow_with_the_number_of_records() {
    let temp = Folder::new("memory");
    let peak = |total: u64| {
        let store = Store::open(&temp.path(&total.to_string()), STUDY, IDENTITY, total, None).unwrap();
        let mut records = Vec::new();
        for chunk in store.own_chunks() {
            records.clear();
            records.extend(store.range(chunk).map(|index| 1_000_000 + index));
            store.write(chunk, &records).unwrap();
        }
        let mut sum = 0;
        let read = allocation_counter::measure(|| sum = store.records::<u64>().map(Result::unwrap).sum());
        assert_eq!(sum, 1_000_000 * total + total * (total - 1) / 2);
        let mut survey = None;
        let surveyed = allocation_counter::measure(|| survey = Some(store.survey().unwrap()));
        assert!(survey.unwrap().missing.is_empty());
        [read.bytes_max, surveyed.bytes_max]
    };
    // Both have chunks of 64.
    let (few, many) = (peak(10_000), peak(100_000));
    assert!(few.iter().zip(many).all(|(few, many)| many <= few + 64), "{few:?} {many:?}");
    // The file (8 bytes and more a record), the records and their results
    assert!(many.iter().all(|&bytes| bytes < 10_000), "{many:?}");
}

#[test]
fn a_job_that_panics_stops_the_others_and_loses_nothing_that_is_done() {
    let temp = Folder::new("panic");
    let expected = whole(&temp.path("whole"));
    for threads in [1, 2] {
        let folder = temp.path(&threads.to_string());
        let store = open(&folder, None).unwrap();
        let survey = store.survey().unwrap();
        let begun = AtomicU64::new(0);
        let job = |index| {
            begun.fetch_add(1, Relaxed);
            sleep(Duration::from_millis(1));
            if index == 28 { std::panic::resume_unwind(Box::new("a defect")) } else { Some(record(index)) }
        };
        let work = || parallel::run_chunks(&store, &survey, job, |_| {}, || false);
        let work = std::panic::AssertUnwindSafe(|| parallel::with_threads(Some(threads), work));
        let panicked = std::panic::catch_unwind(work).unwrap_err();
        assert_eq!(panicked.downcast_ref(), Some(&"a defect"));
        assert!(begun.load(Relaxed) < TOTAL / 4, "{begun:?} with {threads}");
        let missing = store.survey().unwrap().missing;
        assert!(missing[0] == 3 && missing.len() as u64 >= CHUNKS - begun.into_inner() / 8, "{missing:?}");
        drop(store);
        assert!(whole(&folder) == expected);
    }
}

#[test]
fn a_record_that_json_does_not_carry_is_refused_when_it_is_written() {
    let temp = Folder::new("nan");
    let store = Store::open(&temp.path("a"), STUDY, IDENTITY, 3, None).unwrap();
    let job = |index| Some(if index == 2 { f64::NAN } else { 1.0 });
    let failed = parallel::run_chunks(&store, &store.survey().unwrap(), job, |_| {}, || false);
    says(failed, &["record 2", "null"]);
}

#[test]
#[should_panic(expected = "the store is only read")]
fn a_store_that_is_read_is_not_written() {
    let temp = Folder::new("reader");
    drop(Store::open(&temp.path("a"), STUDY, IDENTITY, 1, None).unwrap());
    let _ = Store::read(&temp.path("a")).unwrap().write(0, &[1]);
}

#[test]
fn a_study_of_nothing_is_complete() {
    let temp = Folder::new("nothing");
    let store = Store::open(&temp.path("a"), STUDY, IDENTITY, 0, None).unwrap();
    store.check_space(1000, 0).unwrap();
    assert!(store.is_complete().unwrap() && store.records::<Record>().next().is_none());
    assert_eq!(store.text(), STUDY);
}

#[test]
fn results_are_in_order_whatever_the_threads_do() {
    for threads in [1, 2, 5] {
        let squares = || parallel::run_all(1000, |index| Some(index * index));
        let squares = parallel::with_threads(Some(threads), squares).unwrap().unwrap();
        assert!(squares.into_iter().eq((0..1000).map(|index| index * index)), "{threads}");
    }
    assert_eq!(parallel::run_all(10, |index| (index != 7).then_some(index)), None);
    assert_eq!(parallel::run_all(0, Some), Some(vec![]));
    says(parallel::with_threads(Some(0), || ()), &["threads", "at least 1, found 0"]);
}

#[test]
fn whoever_is_free_takes_what_is_left() {
    let temp = Folder::new("balance");
    let store = Store::open(&temp.path("a"), STUDY, IDENTITY, 100, None).unwrap();
    let survey = store.survey().unwrap();
    for slow in [0, 49, 99] {
        let others = AtomicU64::new(0);
        // One job lasts until all the others are done, which takes another that does them all.
        let job = |index: u64| {
            if index != slow {
                others.fetch_add(1, Relaxed);
            } else {
                let patience = 60_000;
                let done = (0..patience).any(|_| {
                    sleep(Duration::from_millis(1));
                    others.load(Relaxed) == 99
                });
                assert!(done, "only {others:?} of 99 while number {slow} lasts");
            }
            Some(index)
        };
        let all = parallel::with_threads(Some(2), || parallel::run_all(100, |index| job(index as u64)));
        assert!(all.unwrap().unwrap().into_iter().eq(0..100));
        others.store(0, Relaxed);
        let done = parallel::with_threads(Some(2), || parallel::run_chunks(&store, &survey, job, |_| {}, || false));
        assert!(!done.unwrap().unwrap().is_stopped());
    }
}
