//! `reproduce`: what it finds of the thesis's results, whole once, and that it finds the same on any number of threads.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use legwork_study::parallel::with_threads;
use legwork_thesis::case::{Case, Experiment, Gains, Reading};
use legwork_thesis::claims::{Claim, Verdict};
use legwork_thesis::limits::{LARGEST_PUSH, LARGEST_PUSH_REPLAN, sought};
use legwork_thesis::sweep::{COM, FEET};
use legwork_thesis::trial::{LOW_MOMENTUM, set, trials};
use legwork_thesis::{Reproduction, amount, files, run};

const TORQUE_WALK: &str = "lowest torque limit, walk";

static WHOLE: LazyLock<Reproduction> = LazyLock::new(|| {
    let most = AtomicU64::new(0);
    let told = |done| {
        most.fetch_max(done, Relaxed);
    };
    let whole = run(told, || false).expect("all is built in");
    assert_eq!(most.into_inner(), amount().expect("all is built in"), "progress ends at the amount");
    whole.expect("nobody stopped it")
});

fn claim(id: &str) -> &'static Claim {
    WHOLE.claims.iter().find(|claim| claim.id == id).unwrap_or_else(|| panic!("no claim {id}"))
}

fn verdict(id: &str, reading: Reading) -> Verdict {
    claim(id).findings.iter().find(|finding| finding.reading == reading).expect("both readings are judged").verdict
}

fn near(what: &str, value: Option<f64>, expected: f64, share: f64) {
    let value = value.unwrap_or_else(|| panic!("{what}: none"));
    assert!((value / expected - 1.0).abs() <= share, "{what}: {value} is not near {expected}");
}

#[test]
fn the_key_findings_are_there() {
    use Verdict::*;
    let support = Reading::BaseOfSupport;
    // From 220 to 500 Nm little changes, and the figures say how little.
    assert_eq!(verdict("6.1-g", support), Reproduced);
    for (experiment, bound) in [(Experiment::Walk, 0.04), (Experiment::Push, 0.01)] {
        let sweep = WHOLE.evidence.sweep("torque-limit", support, experiment);
        let at = |level: f64| sweep.at(level).and_then(|tried| tried.figure(COM)).expect("it stands");
        assert!((at(500.0) / at(220.0) - 1.0).abs() < bound);
    }
    // The default reading's baseline falls in the push, so that nothing can be said of the sweeps around it.
    assert!(!WHOLE.evidence.trial(Case::new(Reading::Displacement, Experiment::Push, Gains::Baseline), &[]).stands());
    assert_eq!(verdict("7.1.5-d", Reading::Displacement), Not);
    for (id, expected) in
        [("7.1.4-c", Reproduced), ("7.1.4-e", Reproduced), ("6.3.5-a", Reproduced), ("7.1.2-a", Reproduced)]
    {
        assert_eq!(verdict(id, support), expected, "{id}");
    }
    for reading in Reading::ALL {
        assert_eq!(WHOLE.counts(reading).iter().sum::<usize>(), WHOLE.claims.len());
        assert_eq!(verdict("7.1-a", reading), Reproduced);
    }
}

#[test]
fn limits_and_tables_agree_with_the_runs_they_are_of() {
    let support = Reading::BaseOfSupport;
    near("largest push", WHOLE.evidence.limit(LARGEST_PUSH, support).value, 158.0, 0.05);
    let replanned = WHOLE.evidence.limit(LARGEST_PUSH_REPLAN, support).value;
    assert!(replanned > WHOLE.evidence.limit(LARGEST_PUSH, support).value);
    let run = WHOLE.evidence.final_run(support, Experiment::Push);
    assert_eq!(WHOLE.evidence.limit("recovery time", support).value, run.metrics.recovery_time_s);
    let table = WHOLE.tables.iter().find(|table| table.number == "6.5").expect("Table 6.5");
    let row = table.rows.iter().find(|row| row.label == "joint torque" && row.kind == "mean").expect("it has torques");
    let cell = row.measured.iter().find(|cell| cell.reading == support).expect("both readings");
    assert_eq!((row.thesis, cell.value), (59.6, Some(run.metrics.torque_nm.expect("it is measured").mean)));
    near("mean torque", cell.value, 59.6, 0.05);
    // The sweeps meet the runs: the marked level is the baseline.
    for case in Case::all().filter(|case| case.gains == Gains::Baseline) {
        let baseline = WHOLE.evidence.trial(case, &[]);
        for sweep in WHOLE.evidence.sweeps.iter().filter(|sweep| sweep.case == case) {
            let marked = &sweep.at_marked().rollout;
            assert_eq!(marked.ending, baseline.rollout.ending, "{} {}", sweep.study, sweep.scenario);
            // Levels in equal ratios miss the marked one by rounding, which the push may answer with other last digits.
            let exact = marked.result_hash == baseline.rollout.result_hash;
            let index = WHOLE.columns.iter().position(|column| column.name == FEET).expect("a figure");
            let pair = [marked, &baseline.rollout].map(|rollout| rollout.figures[index].expect("a figure"));
            assert!(exact || (pair[0] / pair[1] - 1.0).abs() < 0.05, "{} {}: {pair:?}", sweep.study, sweep.scenario);
        }
    }
}

/// What `claims.toml` says of 6.3.4: the momentum weight matters where it is as small as the operating weights.
#[test]
fn a_momentum_weight_of_the_size_of_the_operating_weights_makes_the_robot_fall() {
    for reading in Reading::ALL {
        let case = Case::new(reading, Experiment::Walk, Gains::Baseline);
        let stands =
            LOW_MOMENTUM.map(|value| WHOLE.evidence.trial(case, &[set("controller.weights.momentum", value)]).stands());
        assert_eq!(stands, [true, false], "{}", case.scenario());
    }
}

#[test]
fn what_is_not_reproduced_has_a_reason_and_all_findings_have_figures() {
    for claim in &WHOLE.claims {
        for finding in &claim.findings {
            assert!(!finding.checks.is_empty() && finding.checks.iter().all(|check| !check.finding.is_empty()));
            let explained = finding.why.is_some();
            assert_eq!(explained, finding.verdict != Verdict::Reproduced, "{} {:?}", claim.id, finding.reading);
        }
    }
    for question in &WHOLE.questions {
        assert!(!question.answer.is_empty() && !question.answer.contains("inf"), "{}", question.answer);
        for table in &question.tables {
            assert!(!table.rows.is_empty() && table.rows.iter().all(|row| row.len() == table.columns.len()));
        }
    }
}

#[test]
fn the_files_hold_every_row_and_their_sources_name_their_columns() {
    let folder = std::env::temp_dir().join(format!("legwork-reproduce-{}", std::process::id()));
    files::write(&WHOLE, &folder).expect("a folder for temporary files");
    let read = |name: &str| {
        let mut reader = csv::Reader::from_path(folder.join(format!("{name}.csv"))).expect("the file is there");
        let head: Vec<String> = reader.headers().expect("a head").iter().map(str::to_owned).collect();
        (head, reader.into_records().collect::<Result<Vec<_>, _>>().expect("rows of one length").len())
    };
    let levels: usize = WHOLE.evidence.sweeps.iter().map(|sweep| sweep.levels.len()).sum();
    assert_eq!(read("sweeps").1, levels);
    assert_eq!(read("runs").1, trials().len() + Case::all().count());
    assert_eq!(read("limits").1, WHOLE.evidence.limits.len());
    assert!(read("claims").1 >= 2 * WHOLE.claims.len());
    for claim in WHOLE.claims.iter().filter(|claim| claim.source.file != "logs") {
        let (head, _) = read(&claim.source.file);
        for name in &claim.source.columns {
            let found = head.iter().any(|column| column.split(' ').next() == Some(name.as_str()));
            assert!(found, "{}: {}.csv has no column {name}", claim.id, claim.source.file);
        }
    }
    for claim in WHOLE.claims.iter().filter(|claim| claim.source.file == "logs") {
        let columns = WHOLE.evidence.runs[0].log.columns();
        for name in &claim.source.columns {
            assert!(columns.iter().any(|column| column.name == *name), "{}: no column {name}", claim.id);
        }
    }
    for case in Case::all() {
        assert!(folder.join(files::LOGS).join(format!("{}.parquet", case.scenario())).exists());
    }
    std::fs::remove_dir_all(&folder).expect("it was made here");
}

#[test]
fn one_thread_finds_what_many_find() {
    let alone = |work: &(dyn Fn() + Sync)| with_threads(Some(1), work).expect("one thread");
    alone(&|| {
        let sought = sought().iter().find(|sought| sought.quantity == TORQUE_WALK).expect("it is sought");
        let answer =
            sought.search(Reading::BaseOfSupport, || false).expect("it is built in").expect("nobody stopped it");
        assert_eq!(answer.found.value, WHOLE.evidence.limit(TORQUE_WALK, Reading::BaseOfSupport).value);
    });
    for trial in trials().into_iter().step_by(29) {
        let run = trial.run(|| false).expect("it is built in");
        let many = WHOLE.evidence.trials.iter().find(|result| result.trial == trial).expect("it was run");
        assert_eq!(format!("{:032x}", run.result_hash), many.rollout.result_hash, "{}", trial.command());
    }
}

#[test]
fn stopping_ends_it_without_a_result() {
    assert!(run(|_| (), || true).expect("all is built in").is_none());
}
