//! A peer of beltsort's devices on ROS 2 that contains no code of ROS 2: `RustDDS` under ros2-client. It is written from
//! docs/ros.md and behaves as the peer of tests/drivers/ros2, so that the same tests hold for it.
//!
//! The domain is that of `ROS_DOMAIN_ID`. A line of JSON on standard input changes what the peer does, and is answered by the
//! state of its world.
//!
//! What it cannot do, as measured with `RustDDS` 0.15.1 and Fast DDS: of depth images of 640 x 480 pixels (600 kB), which are
//! sent in hundreds of packets at once, one arrives in several seconds, so that its own are small; and after its process was
//! stopped and continued (SIGSTOP, SIGCONT), its messages may no longer arrive.

mod arm;
mod machine;
mod messages;

use std::error::Error;
use std::io::BufRead;
use std::sync::Arc;
use std::thread;

use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{
    Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::arm::{Shared, locked};
use crate::machine::{BEAT, Change, Machine};
use crate::messages::{
    Bool, CameraInfo, DiagnosticArray, DiagnosticStatus, Empty, Header, Image, Int32, JointState,
    JointTrajectory, KeyValue,
};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const HEIGHT: u32 = 120;
const WIDTH: u32 = 160;
const TRAJECTORY: &str = "/arm_controller/joint_trajectory";
const SCAN_EVERY: u64 = 25;

/// Reliable; a publisher does not wait for subscriptions that acknowledge nothing, because they are frozen for example.
fn quality() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .history(History::KeepLast { depth: 10 })
}

fn type_name(kind: &str) -> Result<MessageTypeName> {
    let (package, name) = kind.split_once('/').ok_or("a type is package/Name")?;
    Ok(MessageTypeName::new(package, name))
}

fn advertise<M: Serialize>(
    node: &mut Node,
    topic: &str,
    kind: &str,
    quality: &QosProfile,
) -> Result<Publisher<M>> {
    let topic = node.create_topic(&Name::parse(topic)?, type_name(kind)?, quality)?;
    Ok(node.create_publisher(&topic, None)?)
}

fn hear<M: DeserializeOwned + Send + Sync + 'static>(
    node: &mut Node,
    topic: &str,
    kind: &str,
    mut receive: impl FnMut(M) + Send + 'static,
) -> Result<()> {
    let topic = node.create_topic(&Name::parse(topic)?, type_name(kind)?, &quality())?;
    let subscription = node.create_subscription::<M>(&topic, None)?;
    smol::spawn(async move {
        loop {
            match subscription.async_take().await {
                Ok((message, _)) => receive(message),
                Err(reason) => eprintln!("a message was lost: {reason:?}"),
            }
        }
    })
    .detach();
    Ok(())
}

/// What the peer publishes.
struct Reports {
    joints: Publisher<JointState>,
    belt: Publisher<Int32>,
    sorter: Publisher<DiagnosticArray>,
    emergency: Publisher<Bool>,
    depth: Publisher<Image>,
    info: Publisher<CameraInfo>,
}

impl Reports {
    fn new(node: &mut Node) -> Result<Self> {
        let quality = quality();
        Ok(Self {
            joints: advertise(node, "/robot/joint_states", "sensor_msgs/JointState", &quality)?,
            belt: advertise(node, "/belt/object", "std_msgs/Int32", &quality)?,
            sorter: advertise(node, "/sorter/state", "diagnostic_msgs/DiagnosticArray", &quality)?,
            emergency: advertise(node, "/emergency_stop", "std_msgs/Bool", &quality)?,
            depth: advertise(node, "/camera/depth/image_rect", "sensor_msgs/Image", &quality)?,
            info: advertise(node, "/camera/depth/camera_info", "sensor_msgs/CameraInfo", &quality)?,
        })
    }

    /// Goes on by a beat, and publishes. A message that cannot be sent is followed by the next one.
    fn beat(&self, shared: &Shared, n: u64) {
        let (emergency, said, scans) = {
            let mut machine = locked(shared); // not while publishing, which may take a while
            let said = machine.beat().then(|| (joint_state(&machine), machine.belt(), report(&machine)));
            (machine.settings.emergency, said, machine.settings.cloud != "silent")
        };
        let _ = self.emergency.publish(Bool { data: emergency });
        if let Some((joints, belt, keys)) = said {
            let _ = self.joints.publish(joints);
            let _ = self.belt.publish(Int32 { data: belt });
            let _ = self.sorter.publish(keys);
        }
        if scans && n.is_multiple_of(SCAN_EVERY) {
            let (image, info) = scan();
            let _ = self.info.publish(info);
            let _ = self.depth.publish(image);
        }
    }
}

fn joint_state(machine: &Machine) -> JointState {
    let (name, position) = machine.joints.clone().into_iter().unzip();
    JointState { header: Header::now(""), name, position, ..Default::default() }
}

fn report(machine: &Machine) -> DiagnosticArray {
    let status = machine.keys().iter().map(|(key, verdict)| DiagnosticStatus {
        name: key.clone(),
        message: verdict.1.clone(),
        values: vec![KeyValue { key: "state".to_owned(), value: verdict.0.to_owned() }],
        ..Default::default()
    });
    DiagnosticArray { header: Header::now(""), status: status.collect() }
}

/// A depth image of a slope: 0.5 m in the first row, a millimetre more in each row that follows.
fn scan() -> (Image, CameraInfo) {
    let header = Header::now("optical");
    let mut data = Vec::new();
    for row in 0..HEIGHT {
        let depth = u16::try_from(500 + row).unwrap_or(u16::MAX);
        data.extend((0..WIDTH).flat_map(|_| depth.to_le_bytes()));
    }
    let image = Image {
        header: header.clone(),
        height: HEIGHT,
        width: WIDTH,
        encoding: "16UC1".to_owned(),
        is_bigendian: 0,
        step: 2 * WIDTH,
        data,
    };
    let k = [125.0, 0.0, 79.5, 0.0, 125.0, 59.5, 0.0, 0.0, 1.0];
    (image, CameraInfo { header, height: HEIGHT, width: WIDTH, k, ..Default::default() })
}

fn listen_to_commands(node: &mut Node, machine: &Shared) -> Result<()> {
    let (target, stop) = (Arc::clone(machine), Arc::clone(machine));
    let (command, sorter_stop) = (Arc::clone(machine), Arc::clone(machine));
    let arm = Arc::clone(machine);
    hear(node, TRAJECTORY, "trajectory_msgs/JointTrajectory", move |m: JointTrajectory| {
        if let Some(last) = m.points.last() {
            locked(&arm).go(&m.joint_names, &last.positions);
        }
    })?;
    hear(node, "/belt/target", "std_msgs/Int32", move |m: Int32| locked(&target).advance(m.data))?;
    hear(node, "/belt/stop", "std_msgs/Empty", move |_: Empty| locked(&stop).halt_belt())?;
    hear(node, "/sorter/command", "diagnostic_msgs/KeyValue", move |m: KeyValue| {
        locked(&command).sort(&m.key, &m.value);
    })?;
    hear(node, "/sorter/stop", "std_msgs/Empty", move |_: Empty| locked(&sorter_stop).halt_sorter())
}

fn main() -> Result<()> {
    let domain = std::env::var("ROS_DOMAIN_ID").unwrap_or_default().parse().unwrap_or(0);
    let context = Context::with_options(ContextOptions::new().domain_id(domain))?;
    let mut node = context.new_node(NodeName::new("/", "peer")?, NodeOptions::new())?;
    smol::spawn(node.spinner()?.spin()).detach();
    let machine = Shared::default();
    let reports = Reports::new(&mut node)?;
    let kept = quality().durability(Durability::TransientLocal);
    let latched = advertise(&mut node, "/latched_stop", "std_msgs/Bool", &kept)?;
    latched.publish(Bool { data: true }).map_err(|reason| format!("{reason:?}"))?;
    listen_to_commands(&mut node, &machine)?;
    arm::serve(&mut node, "/arm", "follow_joint_trajectory", &machine)?;

    let beating = Arc::clone(&machine);
    thread::spawn(move || {
        for n in 0.. {
            reports.beat(&beating, n);
            thread::sleep(BEAT);
        }
    });
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let told: Change = serde_json::from_str(&line?)?;
        let mut machine = locked(&machine);
        machine.settings.change(told);
        println!("{}", serde_json::to_string(&machine.world())?);
    }
    Ok(())
}
