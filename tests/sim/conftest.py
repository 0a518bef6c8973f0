"""A cell without errors, and one as it comes."""

import pytest

from beltsort.sim import ArmErrors, CellConfig, SensorNoise

PERFECT_SENSOR = SensorNoise(
    axial_floor=0.0,
    axial_growth=0.0,
    axial_incidence=0.0,
    lateral_floor=0.0,
    lateral_incidence=0.0,
    disparity_step=1e-9,
    grazing=1e6,
    mixed_share=0.0,
    gloss_loss=0.0,
    gloss_loss_grazing=0.0,
    highlight=0.0,
    gloss_depth=0.0,
    gloss_bias=0.0,
)


@pytest.fixture
def perfect_sensor() -> SensorNoise:
    return PERFECT_SENSOR


@pytest.fixture
def perfect() -> CellConfig:
    return CellConfig(noise=PERFECT_SENSOR, arm=ArmErrors(position=0.0, angle=0.0))
