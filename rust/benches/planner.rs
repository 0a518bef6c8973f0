//! How fast planning is, through the public interface alone: `cargo bench -p beltsort-benches`, with
//! `-- --test` behind it to see whether everything runs.

use std::hint::black_box;

use beltsort_core::{
    Belief, BeliefSearch, Budget, Despot, DespotConfig, EvaluationConfig, ModelSpec, Plan, Result,
    SortingModel, Threshold, Viewpoint, evaluate,
};
use criterion::{BenchmarkId, Criterion, Throughput};
use rayon::ThreadPoolBuilder;

const TRIALS: u64 = 50;
/// Enough for batches of leaves that are worth sharing.
const SHARED_TRIALS: u64 = 1000;
const FEW_SCENARIOS: usize = 512;
const MANY_SCENARIOS: usize = 4096;
const BATCHES: usize = 1000;

fn main() -> Result<()> {
    let model = SortingModel::new(ModelSpec::from_json(include_str!("../../tests/fixtures/paper.json"))?)?;
    let mut criterion = Criterion::default().configure_from_args();
    ready_to_plan(&mut criterion, &model);
    one_plan(&mut criterion, &model)?;
    by_threads(&mut criterion, &model)?;
    simulation(&mut criterion, &model)?;
    criterion.final_summary();
    Ok(())
}

/// What a planner does once, before its first plan: solve the one-object problem.
fn ready_to_plan(criterion: &mut Criterion, model: &SortingModel) {
    criterion.bench_function("ready to plan", |b| b.iter(|| recommended(black_box(model))));
}

/// A plan's latency, and its work per second: (scenario, action) pairs simulated, and nodes expanded.
fn one_plan(criterion: &mut Criterion, model: &SortingModel) -> Result<()> {
    for scenarios in [FEW_SCENARIOS, MANY_SCENARIOS] {
        let planner = planner(model, scenarios)?;
        let done = plan(&planner)?;
        for (unit, count) in [("scenario steps", done.scenario_steps), ("expansions", done.expansions)] {
            let mut group = criterion.benchmark_group(format!("plan of {TRIALS} trials in {unit}"));
            group.throughput(Throughput::Elements(count));
            group.bench_function(BenchmarkId::new("scenarios", scenarios), |b| b.iter(|| plan(&planner)));
        }
    }
    let (search, belief, budget) = (recommended(model)?, Belief::new(model), Budget::Trials(TRIALS));
    let done = search.plan(&belief, Viewpoint(0), budget)?;
    let mut group = criterion.benchmark_group(format!("recommended plan of {TRIALS} trials in expansions"));
    group.throughput(Throughput::Elements(done.expansions));
    group.bench_function("exact beliefs", |b| b.iter(|| search.plan(&belief, Viewpoint(0), budget)));
    Ok(())
}

/// The same plan on one thread and on two.
fn by_threads(criterion: &mut Criterion, model: &SortingModel) -> Result<()> {
    let planner = planner(model, MANY_SCENARIOS)?;
    let mut group = criterion.benchmark_group(format!("plan of {SHARED_TRIALS} trials"));
    for threads in [1, 2] {
        let Ok(pool) = ThreadPoolBuilder::new().num_threads(threads).build() else { continue };
        let id = BenchmarkId::new("threads", threads);
        group.bench_function(id, |b| b.iter(|| pool.install(|| plan_in_parallel(&planner))));
    }
    Ok(())
}

/// Simulated batches with a policy that costs next to nothing.
fn simulation(criterion: &mut Criterion, model: &SortingModel) -> Result<()> {
    let policy = Threshold::new(model, 0.94, None)?;
    let config = EvaluationConfig { batches: BATCHES, ..EvaluationConfig::default() };
    let mut group = criterion.benchmark_group("evaluate a threshold in batches");
    group.throughput(Throughput::Elements(BATCHES as u64));
    group.bench_function(BATCHES.to_string(), |b| b.iter(|| evaluate(model, model, &policy, &config)));
    Ok(())
}

fn recommended(model: &SortingModel) -> Result<BeliefSearch> {
    BeliefSearch::new(model, DespotConfig { scenarios: FEW_SCENARIOS, ..DespotConfig::default() })
}

/// DESPOT as published.
fn planner(model: &SortingModel, scenarios: usize) -> Result<Despot> {
    Despot::new(model, DespotConfig { scenarios, ..DespotConfig::default() })
}

fn plan(planner: &Despot) -> Result<Plan> {
    planner.plan(&Belief::new(planner.model()), Viewpoint(0), Budget::Trials(TRIALS))
}

fn plan_in_parallel(planner: &Despot) -> Result<Plan> {
    planner.plan_in_parallel(&Belief::new(planner.model()), Viewpoint(0), Budget::Trials(SHARED_TRIALS))
}
