//! The viewpoint feature histogram of a point cloud (Rusu, Bradski, Thibaux & Hsu, IROS 2010).

use nalgebra::Vector3;
use std::f64::consts::PI;

/// Bins of each of the four blocks about the centroid.
const ANGLE_BINS: usize = 45;
/// Bins of the block about the viewpoint.
const VIEWPOINT_BINS: usize = 128;
const BINS_PER_METRE: f64 = 100.0;

/// Bins of a histogram.
pub const VFH_BINS: usize = 4 * ANGLE_BINS + VIEWPOINT_BINS;

/// What a histogram counts of the distances from the centroid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distances {
    /// Centimetres, to the nearest.
    Centimetres,
    /// Shares of the largest.
    Shares,
}

/// What goes into a histogram.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct VfhOptions {
    /// Whether, and how, distances from the centroid are counted.
    pub distances: Option<Distances>,
    /// Count points instead of percent.
    pub raw_counts: bool,
    /// Let the centroid's homogeneous 1 into the norms of distances, as PCL 1.13 does.
    pub pcl_compatible: bool,
}

/// The histogram of `points` (metres) with their unit `normals`, as many of these as of those, all finite.
///
/// `None` where the viewpoint is the centroid, so that no viewing direction exists, and of fewer than two points.
#[must_use]
pub fn vfh(
    points: &[[f64; 3]],
    normals: &[[f64; 3]],
    viewpoint: [f64; 3],
    options: VfhOptions,
) -> Option<[f64; VFH_BINS]> {
    let (centroid, mean_normal) = (mean(points), mean(normals));
    let leak = if options.pcl_compatible { 1.0 } else { 0.0 };
    let towards_eye = Vector3::from(viewpoint) - centroid;
    let eye_distance = (towards_eye.norm_squared() + leak).sqrt();
    if points.len() < 2 || eye_distance == 0.0 {
        return None;
    }
    let towards_eye = towards_eye / eye_distance;
    let size_scale = size_scale(points, &centroid, leak, options.distances);

    let [mut theta, mut alpha, mut phi, mut size] = [[0_u32; ANGLE_BINS]; 4];
    let mut view = [0_u32; VIEWPOINT_BINS];
    for (point, normal) in points.iter().zip(normals) {
        let (offset, normal) = (Vector3::from(*point) - centroid, Vector3::from(*normal));
        count(&mut view, VIEWPOINT_BINS as f64 * (normal.dot(&towards_eye) + 1.0) / 2.0);
        if let Some(pair) = pair_features(&offset, &mean_normal, &normal) {
            count(&mut theta, angle_bin(pair.theta));
            count(&mut alpha, angle_bin(pair.cos_alpha));
            count(&mut phi, angle_bin(pair.cos_phi));
            if let Some((scale, shift)) = size_scale {
                count(&mut size, scale * pair.distance + shift);
            }
        }
    }

    let n = points.len() as f64;
    let (per_pair, per_point) = if options.raw_counts { (1.0, 1.0) } else { (100.0 / (n - 1.0), 100.0 / n) };
    let pairs = [theta, alpha, phi, size];
    let shape = pairs.as_flattened().iter().map(|&bin| per_pair * f64::from(bin));
    let mut histogram = [0.0; VFH_BINS];
    let bins = shape.chain(view.iter().map(|&bin| per_point * f64::from(bin)));
    histogram.iter_mut().zip(bins).for_each(|(to, bin)| *to = bin);
    Some(histogram)
}

/// How a point's normal lies to the mean normal, seen along the line from the centroid.
struct PairFeatures {
    theta: f64,
    cos_alpha: f64,
    cos_phi: f64,
    distance: f64,
}

/// `None` without a frame: at the centroid, and where the offset is parallel to the normal that the frame starts from.
fn pair_features(
    offset: &Vector3<f64>,
    mean_normal: &Vector3<f64>,
    normal: &Vector3<f64>,
) -> Option<PairFeatures> {
    let distance = offset.norm();
    let direction = offset / distance;
    let (cos_mean, cos_own) = (direction.dot(mean_normal), direction.dot(normal));
    let (u, other, direction, cos_phi) = if cos_mean.abs() < cos_own.abs() {
        (normal, mean_normal, -direction, -cos_own)
    } else {
        (mean_normal, normal, direction, cos_mean)
    };
    let across = direction.cross(u);
    let v = across / across.norm();
    let w = u.cross(&v);
    let (theta, cos_alpha) = (w.dot(other).atan2(u.dot(other)), v.dot(other));
    let defined = !(theta.is_nan() || cos_alpha.is_nan() || cos_phi.is_nan());
    defined.then_some(PairFeatures { theta, cos_alpha, cos_phi, distance })
}

/// Factor and summand that turn a distance into a bin, if distances are counted.
fn size_scale(
    points: &[[f64; 3]],
    centroid: &Vector3<f64>,
    leak: f64,
    distances: Option<Distances>,
) -> Option<(f64, f64)> {
    let squared = |point: &[f64; 3]| (Vector3::from(*point) - centroid).norm_squared();
    distances.map(|distances| match distances {
        Distances::Centimetres => (BINS_PER_METRE, 0.5),
        Distances::Shares => {
            let largest = points.iter().map(squared).fold(0.0, f64::max);
            (ANGLE_BINS as f64 / (largest + leak).sqrt(), 0.0)
        }
    })
}

fn angle_bin(feature: f64) -> f64 {
    ANGLE_BINS as f64 * (feature + PI) / (2.0 * PI)
}

/// Count `scaled` in its bin; what lies outside goes to the first or last one.
fn count<const N: usize>(bins: &mut [u32; N], scaled: f64) {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the cast saturates
    let bin = scaled.max(0.0) as usize;
    bins[bin.min(N - 1)] += 1;
}

fn mean(vectors: &[[f64; 3]]) -> Vector3<f64> {
    vectors.iter().map(|vector| Vector3::from(*vector)).sum::<Vector3<f64>>() / vectors.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::seeded;
    use proptest::prelude::*;

    const SHAPE_ONLY: VfhOptions = VfhOptions { distances: None, raw_counts: true, pcl_compatible: false };
    const EYE: [f64; 3] = [0.3, -0.2, 0.9];

    fn cross() -> Vec<[f64; 3]> {
        vec![[0.1, 0.0, 0.0], [-0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, -0.1, 0.0], [0.0; 3]]
    }

    #[test]
    fn a_flat_cross_seen_from_above_fills_one_bin_a_block() {
        let options = VfhOptions { distances: Some(Distances::Centimetres), ..SHAPE_ONLY };
        let histogram = vfh(&cross(), &[[0.0, 0.0, 1.0]; 5], [0.0, 0.0, 1.0], options).unwrap();
        let filled: Vec<_> = histogram.iter().copied().enumerate().filter(|(_, bin)| *bin > 0.0).collect();
        // The point at the centroid has no frame and counts in the last block only.
        assert_eq!(filled, [(22, 4.0), (67, 4.0), (112, 4.0), (145, 4.0), (307, 5.0)]);
    }

    #[test]
    fn no_histogram_without_a_viewing_direction() {
        assert_eq!(vfh(&cross(), &[[0.0, 0.0, 1.0]; 5], [0.0; 3], SHAPE_ONLY), None);
        assert_eq!(vfh(&[[0.1; 3]], &[[0.0, 0.0, 1.0]], EYE, SHAPE_ONLY), None);
    }

    /// Points about the origin and unit normals, as many.
    fn clouds() -> impl Strategy<Value = (Vec<[f64; 3]>, Vec<[f64; 3]>)> {
        let vector = || prop::array::uniform3(-1.0..1.0_f64);
        prop::collection::vec((vector(), vector()), 3..60).prop_map(|rows| {
            let scaled = |(point, normal): ([f64; 3], [f64; 3])| {
                (point.map(|x| 0.1 * x), <[f64; 3]>::from(Vector3::from(normal).normalize()))
            };
            rows.into_iter().map(scaled).unzip()
        })
    }

    proptest! {
        #![proptest_config(seeded(64))]

        #[test]
        fn every_block_counts_every_point_with_a_frame(
            (points, normals) in clouds(), shares: bool, pcl_compatible: bool
        ) {
            let distances = if shares { Distances::Shares } else { Distances::Centimetres };
            let options = VfhOptions { distances: Some(distances), pcl_compatible, ..SHAPE_ONLY };
            let histogram = vfh(&points, &normals, EYE, options).unwrap();
            let sums: Vec<f64> = histogram[..180].chunks(ANGLE_BINS).map(|block| block.iter().sum()).collect();
            let near = |a: f64, b: f64| (a - b).abs() < 0.5;
            prop_assert!(sums.iter().all(|sum| near(*sum, sums[0])));
            prop_assert!(sums[0] <= points.len() as f64);
            prop_assert!(near(histogram[180..].iter().sum(), points.len() as f64));
        }

        #[test]
        fn only_distances_know_the_unit_of_length((points, normals) in clouds()) {
            // Powers of two scale without rounding.
            let scaled: Vec<_> = points.iter().map(|point| point.map(|x| 1024.0 * x)).collect();
            let one = vfh(&points, &normals, EYE, SHAPE_ONLY);
            prop_assert_eq!(one, vfh(&scaled, &normals, EYE.map(|x| 1024.0 * x), SHAPE_ONLY));
        }
    }
}
