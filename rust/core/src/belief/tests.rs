use proptest::prelude::*;

use super::*;
use crate::model::{ModelSpec, ScalarOrMatrix};
use crate::testing::{
    all_labels, belief_of, from_weights, models_in_full, paper, probability, seeded, small_models,
};

/// The joint distribution over the kinds of all positions, and every scan since the belt last moved: the belief
/// without the factoring and without the summary of what was seen.
struct Joint {
    probabilities: Vec<f64>,
    scans: Vec<(Viewpoint, Vec<Option<Label>>)>,
}

impl Joint {
    /// Kinds of all positions behind a joint index.
    fn kinds(model: &SortingModel, mut index: usize) -> Vec<Kind> {
        let mut kinds = Vec::new();
        for _ in 0..model.position_count() {
            kinds.push(Kind(index % model.kind_count()));
            index /= model.kind_count();
        }
        kinds
    }

    fn size(model: &SortingModel) -> usize {
        (0..model.position_count()).map(|_| model.kind_count()).product()
    }

    fn new(model: &SortingModel) -> Self {
        let prior = |i| Self::kinds(model, i).iter().map(|n| model.arrival()[n.0]).product();
        Self { probabilities: (0..Self::size(model)).map(prior).collect(), scans: Vec::new() }
    }

    /// `P(z' | z, v, n)` from the scans, by the definition of `repeat`.
    fn likelihood(
        &self,
        model: &SortingModel,
        position: Position,
        viewpoint: Viewpoint,
        kind: Kind,
        z: Label,
    ) -> f64 {
        let fresh = model.table(position, viewpoint)[(kind.0, z.0)];
        let earlier = self.scans.iter().filter(|(v, _)| *v == viewpoint);
        match earlier.filter_map(|(_, labels)| labels[position.0]).next_back() {
            None => fresh,
            Some(last) => {
                let repeat = model.repeat(position, viewpoint);
                repeat * f64::from(u8::from(last == z)) + (1.0 - repeat) * fresh
            }
        }
    }

    fn observe(&mut self, model: &SortingModel, viewpoint: Viewpoint, labels: &[Option<Label>]) {
        for i in 0..self.probabilities.len() {
            for ((j, kind), label) in model.positions().zip(Self::kinds(model, i)).zip(labels) {
                if let Some(z) = *label {
                    self.probabilities[i] *= self.likelihood(model, j, viewpoint, kind, z);
                }
            }
        }
        self.scans.push((viewpoint, labels.to_vec()));
        let sum: f64 = self.probabilities.iter().sum();
        self.probabilities.iter_mut().for_each(|p| *p /= sum);
    }

    fn advance(&mut self, model: &SortingModel) {
        let mut next = vec![0.0; self.probabilities.len()];
        for (i, p) in self.probabilities.iter().enumerate() {
            let behind = i / model.kind_count();
            for (n, prior) in model.arrival().iter().enumerate() {
                let last = next.len() / model.kind_count();
                next[behind + n * last] += p * prior;
            }
        }
        self.probabilities = next;
        self.scans.clear();
    }

    fn marginal(&self, model: &SortingModel, position: Position, kind: Kind) -> f64 {
        let of_kind = |i: &usize| Self::kinds(model, *i)[position.0] == kind;
        (0..self.probabilities.len()).filter(of_kind).map(|i| self.probabilities[i]).sum()
    }
}

/// Something that happens to a belief.
#[derive(Debug, Clone)]
enum Event {
    Advance,
    Scan(Viewpoint, Vec<Option<Label>>),
}

/// Any history of two positions, viewpoints and at least two classes; a third of the labels is missing.
fn histories() -> impl Strategy<Value = Vec<Event>> {
    let label = || prop::option::weighted(0.7, (0..2_usize).prop_map(Label));
    let scan = (0..2_usize, label(), label()).prop_map(|(v, a, b)| Event::Scan(Viewpoint(v), vec![a, b]));
    prop::collection::vec(prop_oneof![1 => Just(Event::Advance), 3 => scan], 1..10)
}

/// The belief after one more event, cut to what the model has.
fn happen(belief: &mut Belief, model: &SortingModel, event: &Event) {
    match event {
        Event::Advance => belief.advance(model),
        Event::Scan(viewpoint, labels) => {
            let labels = &labels[..model.position_count()];
            belief.observe(model, existing(model, *viewpoint), labels).unwrap();
        }
    }
}

/// A viewpoint that the model has.
fn existing(model: &SortingModel, viewpoint: Viewpoint) -> Viewpoint {
    Viewpoint(viewpoint.0 % model.viewpoint_count())
}

/// Entropy of all classes.
fn entropy(model: &SortingModel, belief: &Belief) -> f64 {
    let kinds = belief.as_slice().chunks_exact(model.kind_count());
    let classes = kinds.flat_map(|kinds| model.class_probabilities(kinds).collect::<Vec<_>>());
    -classes.filter(|b| *b > 0.0).map(|b| b * b.ln()).sum::<f64>()
}

proptest! {
    #![proptest_config(seeded(256))]

    #[test]
    fn factored_belief_is_the_joint_one_given_all_labels(
        spec in models_in_full(),
        arrival in prop::collection::vec(0.1..1.0_f64, 3),
        events in histories(),
    ) {
        let mut spec = spec;
        let prior = &arrival[..spec.classes.len()];
        spec.arrival = Some(prior.iter().map(|p| p / prior.iter().sum::<f64>()).collect());
        let model = SortingModel::new(spec).unwrap();
        let (mut factored, mut joint) = (Belief::new(&model), Joint::new(&model));
        for event in &events {
            happen(&mut factored, &model, event);
            match event {
                Event::Advance => joint.advance(&model),
                Event::Scan(v, labels) => joint.observe(&model, existing(&model, *v), labels),
            }
            for j in model.positions() {
                prop_assert!((factored.position(j).sum() - 1.0).abs() < 1e-12);
                for n in model.kinds() {
                    prop_assert!((factored.position(j)[n.0] - joint.marginal(&model, j, n)).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn no_repeats_are_the_papers_model(spec in small_models(), events in histories()) {
        let plain = SortingModel::new(spec.clone()).unwrap();
        let never = SortingModel::new(ModelSpec { repeat: Some(ScalarOrMatrix::Scalar(0.0)), ..spec }).unwrap();
        let (mut a, mut b) = (Belief::new(&plain), Belief::new(&never));
        for event in &events {
            happen(&mut a, &plain, event);
            happen(&mut b, &never, event);
            prop_assert_eq!(&a, &b);
        }
    }

    #[test]
    fn information_is_the_expected_drop_of_entropy(
        spec in models_in_full(),
        weights in prop::collection::vec(0.01..1.0_f64, 6),
        events in histories(),
    ) {
        let model = SortingModel::new(spec).unwrap();
        let mut belief = belief_of(&model, &weights);
        for event in &events {
            happen(&mut belief, &model, event);
        }
        for viewpoint in model.viewpoints() {
            let mut left = 0.0;
            for labels in all_labels(&model, model.position_count()) {
                let mut posterior = belief.clone();
                let seen: Vec<_> = labels.iter().map(|z| Some(*z)).collect();
                posterior.observe(&model, viewpoint, &seen).unwrap();
                left += probability(&model, &belief, viewpoint, &labels) * entropy(&model, &posterior);
            }
            let bonus = model.spec().information_gain * (entropy(&model, &belief) - left);
            prop_assert!((belief.bonus(&model, viewpoint) - bonus).abs() < 1e-10);
        }
    }

    #[test]
    fn last_labels_rebuild_a_belief(spec in models_in_full(), events in histories()) {
        let model = SortingModel::new(spec).unwrap();
        let mut belief = Belief::new(&model);
        for event in &events {
            happen(&mut belief, &model, event);
        }
        let last = |j| model.viewpoints().map(|v| belief.last_label(&model, j, v)).collect();
        let rows: Vec<_> = model.positions().map(last).collect();
        let row = |j| belief.position(j).iter().copied().collect();
        let probabilities: Vec<_> = model.positions().map(row).collect();
        let mut other = Belief::from_rows(&model, &probabilities).unwrap().with_last_labels(&model, &rows).unwrap();
        prop_assert_eq!(&other, &belief);
        other.advance(&model);
        let forgotten = |j| model.viewpoints().all(|v| other.last_label(&model, j, v).is_none());
        prop_assert!(model.positions().all(forgotten));
    }
}

#[test]
fn a_repeated_label_tells_less_by_hand() {
    let mut spec = from_weights(1, 1, 2, &[0.8, 0.2, 0.2, 0.8]);
    spec.repeat = Some(ScalarOrMatrix::Scalar(0.5));
    let model = SortingModel::new(spec).unwrap();
    let mut belief = Belief::new(&model);
    belief.observe(&model, Viewpoint(0), &[Some(Label(1))]).unwrap();
    assert!((belief.position(Position(0))[1] - 0.8).abs() < 1e-15);
    // 0.8 (0.5 + 0.5 * 0.8) against 0.2 (0.5 + 0.5 * 0.2).
    belief.observe(&model, Viewpoint(0), &[Some(Label(1))]).unwrap();
    assert!((belief.position(Position(0))[1] - 0.72 / 0.84).abs() < 1e-15);
}

#[test]
fn impossible_label_leaves_the_belief_unchanged() {
    let model = paper(50.0);
    let rows = vec![vec![0.25; 4], vec![1.0, 0.0, 0.0, 0.0]];
    let mut belief = Belief::from_rows(&model, &rows).unwrap();
    let before = belief.clone();
    // Elongated at position 2 is never seen as standard from p3.
    let error = belief.observe(&model, Viewpoint(2), &[Some(Label(0)), Some(Label(3))]).unwrap_err();
    assert_eq!(
        error,
        Error::ImpossibleObservation {
            position: Position(1),
            viewpoint: "p3".into(),
            label: "standard".into()
        }
    );
    assert_eq!(belief, before);
}
