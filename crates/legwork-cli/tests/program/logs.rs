//! Logs in both formats, figures, and scenarios with files of their own.

use std::fs;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;

use crate::{Folder, MODEL};

/// Header and rows.
fn csv(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let header = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    let number = |cell: &str| cell.parse().unwrap_or_else(|_| panic!("{cell:?} is no number"));
    (header, lines.map(|line| line.split(',').map(number).collect()).collect())
}

#[test]
fn csv_and_parquet_hold_the_same_bits() {
    let folder = Folder::new("formats");
    let run = ["run", "push", "--set", "pushes.0.start_s=0.1", "--duration", "0.5", "--json", "--log"];
    let result = folder.json(&[&run[..], &["a.csv"]].concat()).remove(0);
    folder.legwork(&[&run[..], &["a.parquet"]].concat()).succeeds();
    let (header, rows) = csv(&folder.text("a.csv"));
    assert_eq!(rows.len(), 500);
    assert!(rows.iter().flatten().all(|value| value.is_finite()));

    let reader = SerializedFileReader::new(fs::File::open(folder.0.join("a.parquet")).unwrap()).unwrap();
    let metadata = reader.metadata().file_metadata();
    let units = metadata.key_value_metadata().expect("units and hashes");
    let entry = |key: &str| units.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.clone());
    let names: Vec<String> = metadata.schema_descr().columns().iter().map(|column| column.name().to_owned()).collect();
    let titled = |name: &String| entry(&format!("unit:{name}")).map_or(name.clone(), |unit| format!("{name} [{unit}]"));
    assert_eq!(names.iter().map(titled).collect::<Vec<_>>(), header);
    assert_eq!(entry("scenario").as_deref(), Some("push"));
    for hash in ["input_hash", "result_hash"] {
        assert_eq!(entry(hash).as_deref(), result[hash].as_str());
    }
    assert_eq!(metadata.num_rows(), 500);
    for (row, record) in rows.iter().zip(reader.get_row_iter(None).unwrap()) {
        let record = record.unwrap();
        let bits: Vec<u64> = record
            .get_column_iter()
            .map(|(name, field)| match field {
                Field::Double(value) => value.to_bits(),
                other => panic!("{name} is {other}"),
            })
            .collect();
        assert_eq!(bits, row.iter().map(|value| value.to_bits()).collect::<Vec<_>>());
    }
}

#[test]
fn plots_are_svg_files() {
    let folder = Folder::new("plots");
    folder.legwork(&["run", "stand", "walk", "--duration", "0.3", "--plots", "new/plots"]).succeeds();
    let mut count = 0;
    for entry in fs::read_dir(folder.0.join("new/plots")).unwrap() {
        let path = entry.unwrap().path();
        let (name, text) = (path.file_name().unwrap().to_string_lossy(), fs::read_to_string(&path).unwrap());
        assert!(name.ends_with(".svg") && (name.starts_with("stand-") || name.starts_with("walk-")), "{name}");
        assert!(
            text.starts_with("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg ")
                && text.trim_end().ends_with("</svg>"),
            "{name}"
        );
        assert!(text.contains("xmlns=\"http://www.w3.org/2000/svg\"") && !text.contains("NaN"), "{name}");
        count += 1;
    }
    assert!(count >= 8 && count % 2 == 0, "{count}");
}

/// A scenario with a model, a trajectory and a base of its own, in `name/`.
fn project(folder: &Folder, name: &str) {
    folder.file(&format!("{name}/robots/my.toml"), MODEL.replace("name = \"planar_humanoid\"", "name = \"mine\""));
    folder.file(&format!("{name}/data/com.csv"), "t_s,x_m,z_m\n0,0.27025,0.885\n0.5,0.28,0.88\n1,0.29,0.885\n");
    folder.file(&format!("{name}/base.toml"), "[reference.com]\ntrajectory = \"file\"\nfile = \"data/com.csv\"\n");
    let scenario = "extends = \"base.toml\"\nmodel = \"robots/my.toml\"\nduration_s = 0.2\n";
    folder.file(&format!("{name}/my.toml"), scenario);
}

fn hashes(folder: &Folder, arguments: &[&str]) -> [String; 2] {
    let line = folder.json(&[&["run", "--json"], arguments].concat()).remove(0);
    ["input_hash", "result_hash"].map(|key| line[key].as_str().expect("a hash").to_owned())
}

/// The paths of the files were in the hash of the inputs, and `show` printed them as they stood.
#[test]
fn a_run_was_another_one_in_another_folder() {
    let folder = Folder::new("folders");
    project(&folder, "project");
    let expected = hashes(&folder, &["project/my.toml"]);
    let inside = Folder(folder.0.join("project"));
    assert_eq!(hashes(&inside, &["my.toml"]), expected);
    assert_eq!(hashes(&inside, &["../project/my.toml"]), expected);
    let absolute = inside.0.join("my.toml").display().to_string();
    assert_eq!(hashes(&folder, &[&absolute]), expected);
    folder.file("elsewhere/my.toml", inside.legwork(&["show", "my.toml"]).succeeds().out);
    assert_eq!(hashes(&folder, &["elsewhere/my.toml"]), expected);

    // On the command line, paths start from the current folder.
    assert_eq!(hashes(&folder, &["project/my.toml", "--set", "model=project/robots/my.toml"]), expected);
    let own = ["stand", "--set", "model=robots/my.toml", "--duration", "0.2"];
    assert_eq!(hashes(&inside, &own)[1], hashes(&folder, &["stand", "--duration", "0.2"])[1]);
}

#[test]
fn the_trajectory_is_followed() {
    let folder = Folder::new("followed");
    project(&folder, ".");
    folder.legwork(&["run", "my.toml", "--duration", "1.5", "--log", "a.csv"]).succeeds();
    let (header, rows) = csv(&folder.text("a.csv"));
    let column = |name: &str| header.iter().position(|found| found == name).unwrap_or_else(|| panic!("{name}"));
    for (time, x) in [(0, 0.27025), (500, 0.28), (1400, 0.29)] {
        assert!((rows[time][column("com_reference_x [m]")] - x).abs() < 1e-12);
    }
    assert!((rows[1400][column("com_x [m]")] - 0.29).abs() < 0.01, "{}", rows[1400][column("com_x [m]")]);
}
