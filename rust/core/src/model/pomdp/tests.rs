use super::{Flat, number, viewpoint_matters};
use crate::model::{ModelSpec, ScalarOrMatrix, SortingModel};
use crate::testing::{from_weights, paper};

fn text(model: &SortingModel) -> String {
    let mut bytes = Vec::new();
    Flat::new(model).unwrap().write(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// One position, two viewpoints, two classes.
fn tiny() -> SortingModel {
    SortingModel::new(from_weights(1, 2, 2, &[0.75, 0.25, 0.5, 0.5, 1.0, 0.0, 0.125, 0.875])).unwrap()
}

fn changed(change: impl Fn(&mut ModelSpec)) -> SortingModel {
    let mut spec = tiny().spec().clone();
    change(&mut spec);
    SortingModel::new(spec).unwrap()
}

/// What the probabilities of an action's observations in an end state are.
fn observations(text: &str, action: &str, state: &str) -> Vec<String> {
    let start = format!("O: {action} : {state} : ");
    text.lines().filter_map(|line| line.strip_prefix(&start)).map(str::to_owned).collect()
}

#[test]
fn the_viewpoint_is_left_out_where_it_does_not_matter() {
    let mut spec = tiny().spec().clone();
    assert!(!viewpoint_matters(&tiny()));
    assert!(text(&tiny()).contains("states: c0 c1\n"));
    spec.travel = Some(vec![vec![1], vec![1]]);
    assert!(!viewpoint_matters(&SortingModel::new(spec.clone()).unwrap()));
    spec.motion_cost = ScalarOrMatrix::Matrix(vec![vec![7.0, 1.0], vec![9.0, 1.0]]);
    assert!(
        !viewpoint_matters(&SortingModel::new(spec.clone()).unwrap()),
        "the costs of illegal moves do not count"
    );
    spec.travel = Some(vec![vec![1], vec![0, 1]]);
    assert!(viewpoint_matters(&SortingModel::new(spec.clone()).unwrap()));
    spec.travel = None;
    let model = SortingModel::new(spec).unwrap();
    assert!(viewpoint_matters(&model));
    assert!(text(&model).contains("states: v0_c0 v0_c1 v1_c0 v1_c1\n"));
}

#[test]
fn after_a_decision_nothing_is_observed_or_the_scan_from_where_the_camera_stands() {
    assert!(text(&tiny()).contains("observations: z0 z1 nothing\n"));
    assert!(text(&tiny()).contains("O: decide_1 : * : nothing 1.0\n"));
    let observed = text(&changed(|spec| spec.observe_after_decision = true));
    assert!(observed.contains("observations: z0 z1\n"));
    assert_eq!(observations(&observed, "decide_1", "v0_c0"), ["z0 0.75", "z1 0.25"]);
    assert_eq!(observations(&observed, "decide_1", "v1_c0"), ["z0 1.0"]);
    assert_eq!(observations(&observed, "move_1", "v0_c0"), ["z0 1.0"]);
    assert!(!observed.contains("nothing"));
}

#[test]
fn forbidden_moves_can_never_pay() {
    let mut spec = tiny().spec().clone();
    spec.travel = Some(vec![vec![1], vec![0, 1]]);
    spec.discount = 0.5;
    let text = text(&SortingModel::new(spec).unwrap());
    assert!(text.contains("R: move_0 : v0_c1 : * : * -120.0\n"));
    assert!(text.contains("R: move_0 : v1_c1 : * : * -1.0\n"));
}

#[test]
fn what_a_flat_file_cannot_hold_is_refused() {
    let repeating =
        |repeat| changed(|spec| spec.repeat = Some(ScalarOrMatrix::Matrix(vec![vec![0.0, repeat]])));
    let curious = changed(|spec| spec.information_gain = 0.5);
    for (model, key) in [(repeating(0.5), "repeat"), (curious, "information_gain")] {
        let error = Flat::new(&model).err().unwrap().to_string();
        assert!(error.starts_with(&format!("{key} is set")), "{error}");
    }
    assert!(Flat::new(&repeating(0.0)).is_ok());
    let large = |h| SortingModel::new(from_weights(h, 1, 4, &vec![0.5; h * 16])).unwrap();
    assert!(Flat::new(&large(5)).is_ok());
    for h in [6, 16, 40] {
        let error = Flat::new(&large(h)).err().unwrap().to_string();
        assert!(error.contains(&format!("1 * 4^{h} states")), "{error}");
    }
}

#[test]
fn a_missing_folder_is_named() {
    let error = paper(50.0).to_pomdp("absent/paper.pomdp".as_ref()).unwrap_err().to_string();
    assert!(error.starts_with("absent/paper.pomdp: the POMDP file cannot be written"), "{error}");
}

#[test]
fn numbers_have_a_point_and_no_exponent() {
    for (value, written) in
        [(1.0, "1.0"), (-50.0, "-50.0"), (1e-7, "0.0000001"), (0.1, "0.1"), (1e17, "100000000000000000.0")]
    {
        assert_eq!(number(value), written);
    }
}
