//! The model and the CoM samples that a scenario names.

use std::path::Path;

use legwork::library::{load_model, load_samples, model_text};

use crate::{Folder, assert_says};

#[test]
fn models_that_are_none() {
    assert_says(
        load_model("planar_human", None),
        "model",
        &["did you mean planar_humanoid?", "built-in: planar_humanoid"],
    );
    assert!(load_model("missing.toml", Some(Path::new("robots"))).expect_err("there is none").is_io());
    let folder = Folder::new("models");
    folder.file("robots/my.toml", model_text("planar_humanoid").expect("it is built in"));
    assert_eq!(load_model("robots/my.toml", Some(&folder.0)).expect("it is valid").nv(), 7);
}

#[test]
fn samples_are_found_by_the_names_of_their_columns() {
    let folder = Folder::new("samples");
    let path =
        folder.file("com.csv", "# a comment\nz_m, note, t_s, x_m\n0.9, a, 0, 0.1\n0.8, b, 1, 0.2\n0.9, c, 2.5, 3e-1\n");
    let samples = load_samples(Path::new(&path)).expect("it is valid");
    assert_eq!(samples, [[0.0, 0.1, 0.9], [1.0, 0.2, 0.8], [2.5, 0.3, 0.9]]);
}

#[test]
fn samples_that_are_none() {
    let folder = Folder::new("no-samples");
    for (content, line, words) in [
        ("t_s,x_m\n0,0\n", "", "the column z_m is missing; found t_s, x_m; needed are t_s, x_m, z_m"),
        ("", "", "the column t_s is missing"),
        ("t_s,x_m,z_m\n0,0,0.9\n1,0,0.9\n", "", "found 2 rows of samples; at least 3 are needed"),
        (
            "t_s,x_m,z_m\r\n0,0,0.9\r\n\r\n# fast\n1,fast,0.9\n",
            ":5: x_m",
            "found \"fast\"; valid is a number from -1000 to 1000",
        ),
        ("t_s,x_m,z_m\n0,0,nan\n", ":2: z_m", "found \"nan\""),
        ("t_s,x_m,z_m\n0,0,0.9\n1,inf,0.9\n", ":3: x_m", "found \"inf\""),
        ("t_s,x_m,z_m\n-1,0,0.9\n", ":2: t_s", "found \"-1\"; valid is a number from 0 to 3600"),
        ("t_s,x_m,z_m\n\n0,0\n", ":3: z_m", "found \"\"; valid is a number"),
    ] {
        let path = folder.file("bad.csv", content);
        assert_says(load_samples(Path::new(&path)), &format!("{path}{line}"), &[words]);
    }
    let path = folder.file("binary.csv", b"t_s,x_m,z_m\n0,\xff,0\n");
    assert_says(load_samples(Path::new(&path)), &path, &["not UTF-8 text: found the byte 0xff in line 2, column 3"]);
    assert!(load_samples(&folder.0.join("none.csv")).expect_err("there is none").is_io());
    assert!(load_samples(&folder.0).expect_err("it is a folder").is_io());
}
