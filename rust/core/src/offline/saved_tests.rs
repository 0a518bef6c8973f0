use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use super::*;
use crate::belief::Belief;
use crate::index::{Label, Viewpoint};
use crate::policy::Policy;
use crate::testing::{from_weights, paper};

fn solution(model: &SortingModel) -> Solution {
    Solution::solve(model, Duration::from_millis(100), &AtomicBool::new(false), &mut |_, _| {}).unwrap()
}

fn file(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("beltsort-{}-{name}", std::process::id()))
}

#[test]
fn a_loaded_solution_answers_like_the_saved_one() {
    // Without a grid, too: three positions.
    let three = SortingModel::new(from_weights(3, 1, 2, &[0.3; 12])).unwrap();
    for model in [paper(50.0), paper(5.0).with_positions(1).unwrap(), three] {
        let (saved, path) = (solution(&model), file("answers"));
        saved.save(&path).unwrap();
        let loaded = Solution::load(&path, Some(&model)).unwrap();
        std::fs::remove_file(&path).unwrap();
        let (mut belief, viewpoint) = (Belief::new(&model), Viewpoint(0));
        let (lower, upper) = loaded.bounds(&belief, viewpoint).unwrap();
        assert!(saved.lower <= lower && upper <= saved.upper, "as tight as what the search found");
        for label in [0, 1].map(Label) {
            let answers =
                |s: &Solution| (s.bounds(&belief, viewpoint).unwrap(), s.act(&belief, viewpoint).unwrap());
            let pair = [&saved, &loaded].map(answers);
            assert_eq!(pair[0], pair[1]);
            belief.observe(&model, viewpoint, &vec![Some(label); model.position_count()]).unwrap();
        }
        assert_eq!((loaded.lower, loaded.upper, loaded.model()), (saved.lower, saved.upper, &model));
    }
}

#[test]
fn the_first_difference_to_another_model_is_named() {
    let (model, path) = (paper(50.0), file("difference"));
    solution(&model).save(&path).unwrap();
    let refused = |change: &dyn Fn(&mut ModelSpec)| {
        let mut spec = model.spec().clone();
        change(&mut spec);
        Solution::load(&path, Some(&SortingModel::new(spec).unwrap())).map(|_| ()).map_err(|e| e.to_string())
    };
    let error = refused(&|spec| spec.r_min = 5.0).unwrap_err();
    assert!(["r_min", "50", "5"].iter().all(|part| error.contains(part)), "{error}");
    assert!(refused(&|spec| spec.p_obs[1][2][0].swap(0, 3)).unwrap_err().contains("p_obs[1][2][0][0]"));
    assert!(refused(&|spec| spec.arrival = Some(vec![0.25; 4])).unwrap_err().contains("arrival"));
    assert_eq!(refused(&|spec| spec.note = "another".into()), Ok(()), "remarks do not matter");
    std::fs::remove_file(&path).unwrap();
}

#[test]
fn damaged_files_and_other_versions_are_refused() {
    let bytes = solution(&paper(50.0)).to_bytes().unwrap();
    let refused = |bytes: &[u8]| Solution::from_bytes(bytes).unwrap_err().to_string();
    assert!(refused(b"{}").contains("`beltsort solve MODEL -o FILE`"));
    let error = refused(b"beltsort solution 2\n{}\n");
    assert!(["version", "2", "1"].iter().all(|part| error.contains(part)), "{error}");
    for length in [30, bytes.len() / 2, bytes.len() - 1] {
        assert!(refused(&bytes[..length]).contains("damaged"));
    }
    for place in [25, bytes.len() / 2, bytes.len() - 20, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[place] ^= 4;
        assert!(refused(&damaged).contains("damaged"));
    }
}

#[test]
fn files_that_cannot_be_read_or_written_are_named() {
    let missing = file("missing").join("solution");
    assert!(Solution::load(&missing, None).unwrap_err().to_string().contains("missing"));
    let refused = solution(&paper(50.0)).save(&missing).unwrap_err().to_string();
    assert!(refused.contains("missing") && refused.contains("os error"), "{refused}");
}
