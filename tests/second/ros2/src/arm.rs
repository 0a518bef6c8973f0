//! The action server of the arm: goals, feedback, cancellation, results.

use std::collections::BTreeSet;
use std::error::Error;
use std::sync::{Arc, Mutex, MutexGuard};

use ros2_client::action::{ActionServerQosPolicies, AsyncActionServer, GoalEndStatus, NewGoalHandle};
use ros2_client::qos::{Durability, History};
use ros2_client::unique_identifier_msgs::UUID;
use ros2_client::{ActionTypeName, Name, Node, QosProfile, ServiceMapping};

use crate::machine::{BEAT, Machine};
use crate::messages::{Feedback, Goal, Header, JointTrajectoryPoint, Outcome};

const ABORTED: i32 = 4;
const REJECTED: i32 = 5;

type Server = AsyncActionServer<Goal, Outcome, Feedback>;

/// The machine, which threads share. A thread that panicked leaves it as it was.
pub type Shared = Arc<Mutex<Machine>>;

/// Locks the machine.
pub fn locked(machine: &Shared) -> MutexGuard<'_, Machine> {
    machine.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

struct Arm {
    server: Server,
    machine: Shared,
    cancelled: Mutex<BTreeSet<UUID>>,
}

/// Serves the action on the threads of smol.
pub fn serve(node: &mut Node, namespace: &str, action: &str, machine: &Shared) -> Result<(), Box<dyn Error>> {
    let reliable = QosProfile::publisher_default().history(History::KeepLast { depth: 10 });
    let policies = ActionServerQosPolicies {
        goal_service: reliable.clone(),
        result_service: reliable.clone(),
        cancel_service: reliable.clone(),
        feedback_publisher: reliable.clone(),
        status_publisher: reliable.durability(Durability::TransientLocal),
    };
    let kind = ActionTypeName::new("control_msgs", "FollowJointTrajectory");
    let server =
        node.create_action_server(ServiceMapping::Enhanced, &Name::new(namespace, action)?, &kind, policies)?;
    let arm = Arc::new(Arm {
        server: AsyncActionServer::new(server),
        machine: Arc::clone(machine),
        cancelled: Mutex::default(),
    });
    smol::spawn(take_goals(Arc::clone(&arm))).detach();
    smol::spawn(take_cancellations(arm)).detach();
    Ok(())
}

async fn take_goals(arm: Arc<Arm>) {
    loop {
        match arm.server.receive_new_goal().await {
            Ok(goal) => {
                let arm = Arc::clone(&arm);
                smol::spawn(async move {
                    if let Err(reason) = arm.pursue(goal).await {
                        eprintln!("a goal was lost: {reason}");
                    }
                })
                .detach();
            }
            Err(reason) => eprintln!("no goal could be read: {reason:?}"),
        }
    }
}

async fn take_cancellations(arm: Arc<Arm>) {
    loop {
        match arm.server.receive_cancel_request().await {
            Ok(request) => {
                arm.cancelled().extend(request.goals());
                if arm.server.respond_to_cancel_requests(&request, request.goals()).await.is_err() {
                    eprintln!("a request to cancel could not be answered");
                }
            }
            Err(reason) => eprintln!("no request to cancel could be read: {reason:?}"),
        }
    }
}

impl Arm {
    fn cancelled(&self) -> MutexGuard<'_, BTreeSet<UUID>> {
        self.cancelled.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    async fn pursue(&self, goal: NewGoalHandle<Goal>) -> Result<(), String> {
        let verdict = locked(&self.machine).settings.verdict;
        if verdict == REJECTED {
            return self.server.reject_goal(goal).await.map_err(|reason| format!("{reason:?}"));
        }
        let wanted = self.server.get_new_goal(goal.clone()).ok_or("it is not known")?;
        let accepted = self.server.accept_goal(goal).await.map_err(|reason| format!("{reason:?}"))?;
        let executing =
            self.server.start_executing_goal(accepted).await.map_err(|reason| format!("{reason:?}"))?;
        let (status, text) = if verdict == ABORTED {
            (GoalEndStatus::Aborted, "says the peer")
        } else {
            if let Some(last) = wanted.trajectory.points.last() {
                locked(&self.machine).go(&wanted.trajectory.joint_names, &last.positions);
            }
            loop {
                if self.cancelled().remove(&executing.goal_id()) {
                    locked(&self.machine).halt_arm();
                    break (GoalEndStatus::Canceled, "");
                }
                if locked(&self.machine).arrived() {
                    break (GoalEndStatus::Succeeded, "");
                }
                let _ = self.server.publish_feedback(executing.clone(), self.feedback()).await; // not while it is cancelled
                smol::Timer::after(BEAT).await;
            }
        };
        let outcome = Outcome { error_code: 0, error_string: text.to_owned() };
        self.server
            .send_result_response(executing, status, outcome)
            .await
            .map_err(|reason| format!("{reason:?}"))
    }

    fn feedback(&self) -> Feedback {
        let (names, positions) = locked(&self.machine).joints.clone().into_iter().unzip();
        Feedback {
            header: Header::now(""),
            joint_names: names,
            actual: JointTrajectoryPoint { positions, ..Default::default() },
            ..Default::default()
        }
    }
}
