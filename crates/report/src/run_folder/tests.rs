use super::*;
use crate::recording::columns;

fn run_folder(controller: Model) -> RunFolder {
    let mut table = Table::new(columns(6));
    for k in 0..3 {
        let values: Vec<_> = (1..table.names().len()).map(|column| f64::from(k) + column as f64).collect();
        table.push(0.1 * f64::from(k), &values);
    }
    let info = RunInfo {
        format: FORMAT,
        program_version: "0.1.0".to_owned(),
        title: "A run".to_owned(),
        scenario: None,
        controller,
        plant: Model::Library,
        rig: "Table I".to_owned(),
        orbit: None,
        step: 0.1,
        controller_parameters: ControllerParameters::default(),
        plant_parameters: PlantParameters::default(),
    };
    RunFolder { info, table }
}

/// What is said of a folder with one text of one file replaced.
fn refusal(file: &str, from: &str, to: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    run_folder(Model::Library).write(folder.path()).unwrap();
    let path = folder.path().join(file);
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from} is not in {text}");
    fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let refused = RunFolder::read(folder.path()).map_err(|e| e.to_string());
    let refused = refused.and_then(|read| {
        read.run().map_err(|reason| RunFolderError::Csv { path: path.clone(), reason }.to_string())
    });
    let error = refused.expect_err(to);
    assert!(error.contains(path.to_str().unwrap()), "{error}");
    error
}

#[test]
fn what_is_written_is_read_back_and_nothing_else_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/run");
    let fmu = Model::Fmu { path: "a.fmu".into(), name: "A".to_owned(), fmi_version: "3.0".to_owned() };
    let written = run_folder(fmu);
    written.write(&path).unwrap();
    written.write(&path).unwrap();
    assert_eq!(RunFolder::read(&path).unwrap(), written);
    let mut files: Vec<_> = fs::read_dir(&path).unwrap().map(|file| file.unwrap().file_name()).collect();
    files.sort();
    assert_eq!(files, [RUN_CSV, RUN_JSON]);
    let run = written.run().unwrap();
    assert_eq!(run.position[1], written.table.column("plant.encoderPose.y").unwrap());
    assert_eq!(run.slack[5], written.table.column("plant.slack[6]").unwrap());
}

#[test]
fn a_new_run_leaves_neither_the_report_nor_the_json_of_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join(REPORT_HTML);
    fs::write(&report, "of somebody else").unwrap();
    run_folder(Model::Library).write(folder.path()).unwrap();
    assert!(report.is_file(), "no run was there before");
    run_folder(Model::Rig).write(folder.path()).unwrap();
    assert!(!report.exists());

    fs::write(&report, "of the old run").unwrap();
    let RunFolder { info, table } = run_folder(Model::Library);
    GrowingRun::begin(folder.path(), &info, table.names()).unwrap();
    assert!(!report.exists());
}

/// The program may end at any time, and its destructors may not run.
#[test]
fn every_row_is_in_the_file_as_soon_as_it_is_added() {
    let folder = tempfile::tempdir().unwrap();
    let written = run_folder(Model::Library);
    let mut growing = GrowingRun::begin(folder.path(), &written.info, written.table.names()).unwrap();
    for row in 0..written.table.rows() {
        let numbers: Vec<_> =
            written.table.names().iter().map(|name| written.table.column(name).unwrap()[row]).collect();
        growing.add(&numbers).unwrap();
        assert_eq!(RunFolder::read(folder.path()).unwrap().table.rows(), row + 1);
    }
    std::mem::forget(growing);
    assert_eq!(RunFolder::read(folder.path()).unwrap(), written);
    let whole = tempfile::tempdir().unwrap();
    written.write(whole.path()).unwrap();
    for name in [RUN_CSV, RUN_JSON] {
        assert_eq!(fs::read(folder.path().join(name)).unwrap(), fs::read(whole.path().join(name)).unwrap());
    }
}

#[test]
fn a_folder_where_a_file_must_go_is_said_before_the_work() {
    for name in [RUN_CSV, RUN_JSON] {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join(name)).unwrap();
        let error = make(folder.path()).unwrap_err().to_string();
        assert!(error.contains(name) && error.ends_with("it is a folder, a file is wanted"), "{error}");
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let error = make(&file.path().join("run")).unwrap_err().to_string();
    assert!(error.starts_with(&format!("cannot write {}", file.path().display())), "{error}");
}

#[test]
fn broken_files_are_named_with_line_and_what_was_expected() {
    let json = refusal(RUN_JSON, "\"title\": \"A run\",", "\"title\": ,");
    assert!(json.contains("expected value at line 4 column 12"), "{json}");
    let json = refusal(RUN_JSON, "\"step\": 0.1,", "");
    assert!(json.contains("missing field `step` at line"), "{json}");
    let json = refusal(RUN_JSON, "\"step\": 0.1", "\"step\": \"short\"");
    assert!(json.contains("expected f64 at line"), "{json}");
    let format = refusal(RUN_JSON, "\"format\": 2", "\"format\": 3");
    assert!(format.ends_with("format = 3; this program reads format 2"), "{format}");
    let gain = refusal(RUN_JSON, "\"lambda\": 3.0", "\"lambda\": -3.0");
    assert!(gain.contains("controllerParameters: parameter lambda = -3 is not allowed: must be"), "{gain}");
    let step = refusal(RUN_JSON, "\"step\": 0.1", "\"step\": 0.0");
    assert!(step.contains("run.json: run: parameter step = 0 is not allowed"), "{step}");
    let csv = refusal(RUN_CSV, "\n0.1,", "\nsoon,");
    assert!(csv.ends_with("line 3, column 1 (time): \"soon\" is not a finite number"), "{csv}");
    let csv = refusal(RUN_CSV, "controller.setPoint.y", "setPoint.y");
    assert!(csv.ends_with("line 1: there is no column \"controller.setPoint.y\""), "{csv}");
    let missing = RunFolder::read(Path::new("no/such")).unwrap_err().to_string();
    assert!(missing.starts_with("cannot read no/such/run.json: "), "{missing}");
}

#[test]
fn an_fmu_from_elsewhere_may_tell_less() {
    let fmu = Model::Fmu { path: "a.fmu".into(), name: "A".to_owned(), fmi_version: "3.0".to_owned() };
    let RunFolder { info, table } = run_folder(fmu);
    let of_ours = |name: &&String| {
        !name.starts_with("controller.") || name.contains("motor") || name.contains("goalPose")
    };
    let kept: Vec<String> = table.names()[1..].iter().filter(of_ours).cloned().collect();
    let mut less = Table::new(kept.clone());
    for row in 0..table.rows() {
        let values: Vec<_> = kept.iter().map(|name| table.column(name).unwrap()[row]).collect();
        less.push(table.column("time").unwrap()[row], &values);
    }
    let run = RunFolder { info: info.clone(), table: less.clone() }.run().unwrap();
    assert_eq!(run.set_point[2], table.column("controller.goalPose.z").unwrap());
    assert_eq!(run.tension_margin, table.column("plant.measuredTension[1]").unwrap());
    assert_eq!((run.at_goal, run.set_point_index), (vec![0.0; 3], vec![0.0; 3]));
    let ours = RunFolder { info: RunInfo { controller: Model::Library, ..info }, table: less };
    assert!(ours.run().is_err(), "ours tells everything");
}
