use proptest::prelude::*;

use super::*;
use crate::testing::{paper, seeded, small_models};

/// The joint distribution over the classes of all positions: the belief without the factoring.
struct Joint {
    probabilities: Vec<f64>,
}

impl Joint {
    /// Classes of all positions behind a joint index.
    fn classes(model: &SortingModel, mut index: usize) -> Vec<usize> {
        let mut classes = Vec::new();
        for _ in 0..model.position_count() {
            classes.push(index % model.class_count());
            index /= model.class_count();
        }
        classes
    }

    fn size(model: &SortingModel) -> usize {
        (0..model.position_count()).map(|_| model.class_count()).product()
    }

    fn new(model: &SortingModel) -> Self {
        let prior = |i| Self::classes(model, i).iter().map(|c| model.arrival()[*c]).product();
        Self { probabilities: (0..Self::size(model)).map(prior).collect() }
    }

    fn observe(&mut self, model: &SortingModel, viewpoint: usize, labels: &[Option<usize>]) {
        for (i, p) in self.probabilities.iter_mut().enumerate() {
            for (j, class) in Self::classes(model, i).into_iter().enumerate() {
                if let Some(z) = labels[j] {
                    *p *= model.table(j, viewpoint)[(class, z)];
                }
            }
        }
        let sum: f64 = self.probabilities.iter().sum();
        self.probabilities.iter_mut().for_each(|p| *p /= sum);
    }

    fn advance(&mut self, model: &SortingModel) {
        let mut next = vec![0.0; self.probabilities.len()];
        for (i, p) in self.probabilities.iter().enumerate() {
            let behind = i / model.class_count();
            for (c, prior) in model.arrival().iter().enumerate() {
                let last = next.len() / model.class_count();
                next[behind + c * last] += p * prior;
            }
        }
        self.probabilities = next;
    }

    fn marginal(&self, model: &SortingModel, position: usize, class: usize) -> f64 {
        let of_class = |i: &usize| Self::classes(model, *i)[position] == class;
        (0..self.probabilities.len()).filter(of_class).map(|i| self.probabilities[i]).sum()
    }
}

proptest! {
    #![proptest_config(seeded(256))]

    #[test]
    fn factored_belief_is_the_joint_one(
        spec in small_models(),
        arrival in prop::collection::vec(0.1..1.0_f64, 3),
        events in prop::collection::vec((0..3_usize, 0..2_usize, 0..4_usize, 0..4_usize), 1..8),
    ) {
        let mut spec = spec;
        let prior = &arrival[..spec.classes.len()];
        spec.arrival = Some(prior.iter().map(|p| p / prior.iter().sum::<f64>()).collect());
        let model = SortingModel::new(spec).unwrap();
        let (mut factored, mut joint) = (Belief::new(&model), Joint::new(&model));
        for (kind, viewpoint, a, b) in events {
            if kind == 0 {
                factored.advance(&model);
                joint.advance(&model);
            } else {
                let viewpoint = viewpoint % model.viewpoint_count();
                // The label beyond the last class stands for "nothing seen".
                let seen = |z: usize| Some(z % (model.class_count() + 1)).filter(|z| *z < model.class_count());
                let labels = &[seen(a), seen(b)][..model.position_count()];
                factored.observe(&model, viewpoint, labels).unwrap();
                joint.observe(&model, viewpoint, labels);
            }
            for j in 0..model.position_count() {
                prop_assert!((factored.position(j).sum() - 1.0).abs() < 1e-12);
                for c in 0..model.class_count() {
                    prop_assert!((factored.position(j)[c] - joint.marginal(&model, j, c)).abs() < 1e-12);
                }
            }
        }
    }
}

#[test]
fn impossible_label_leaves_the_belief_unchanged() {
    let model = paper(50.0);
    let rows = vec![vec![0.25; 4], vec![1.0, 0.0, 0.0, 0.0]];
    let mut belief = Belief::from_rows(&model, &rows).unwrap();
    let before = belief.clone();
    // Elongated at position 2 is never seen as standard from p3.
    let error = belief.observe(&model, 2, &[Some(0), Some(3)]).unwrap_err();
    assert_eq!(
        error,
        Error::ImpossibleObservation { position: 1, viewpoint: "p3".into(), label: "standard".into() }
    );
    assert_eq!(belief, before);
}
