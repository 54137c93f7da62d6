"""Settings of the pose estimation: what a user or a robot would change, with unit and what each direction costs.

What is left a constant beside the code that uses it is a property of a method or of numbers, not of a camera or a
place.
"""

from __future__ import annotations

from pydantic import Field, model_validator

from razer.settings import Settings
from slam.refinement_settings import RefinementSettings
from slam.submap_settings import SubmapSettings


class FeatureSettings(Settings):
    """ORB features of the colour images, and which of them match."""

    count: int = Field(
        1000,
        ge=400,
        le=10_000,
        description="Most features of an image; where corners are few, as many faint ones are added. Larger: tracking "
        "holds on where there is little depth, at more time a frame.",
    )
    grid_rows: int = Field(
        6,
        ge=1,
        le=50,
        description="Rows of the raster over which features are spread, each cell with its equal share. Larger: more "
        "evenly spread, weaker corners; 1: a poster may take them all.",
    )
    grid_columns: int = Field(
        8,
        ge=1,
        le=50,
        description="Columns of the raster over which features are spread. Larger or smaller: as for grid_rows.",
    )
    pixel_sigma: float = Field(
        1.5,
        gt=0,
        le=20,
        description="Standard deviation of a feature's position at full resolution, pixels. Smaller: features outweigh "
        "depth; larger: depth decides, which slides along bare walls.",
    )
    max_distance_bits: int = Field(
        64,
        ge=1,
        le=256,
        description="Descriptors that differ in so many of their 256 bits do not match. Larger: more matches, more "
        "wrong ones; smaller: few are left after a change of light or view.",
    )
    max_ratio: float = Field(
        0.85,
        gt=0,
        le=1,
        description="The best match must be nearer than this share of the second's distance (Lowe). Larger: more "
        "matches, more wrong ones on repeated texture; smaller: fewer.",
    )

    @property
    def per_cell(self) -> int:
        """Most features of a cell of the raster."""
        return self.count // (self.grid_rows * self.grid_columns)

    @model_validator(mode="after")
    def _cells_have_features(self) -> FeatureSettings:
        if self.per_cell < 1:
            raise ValueError(
                f"count {self.count} leaves no feature to each of {self.grid_rows} x {self.grid_columns} cells"
            )
        return self


class KeyframeSettings(Settings):
    """When tracking goes on from a new keyframe."""

    max_angle_deg: float = Field(
        12.0,
        gt=0,
        le=90,
        description="A keyframe is taken once the camera has turned by more since the last, degrees. Smaller: more "
        "keyframes, time and memory, more drift; larger: tracking is lost on quick turns.",
    )
    max_shift_m: float = Field(
        0.2,
        gt=0,
        le=5,
        description="A keyframe is taken once the camera has moved by more since the last, metres. Smaller or larger: "
        "as for max_angle_deg.",
    )
    min_score: float = Field(
        0.5,
        ge=0,
        le=1,
        description="A keyframe is taken once a smaller share of the view's points lies on the last one's surface. "
        "Larger: more keyframes; smaller: tracking hangs on what little both see.",
    )
    min_agreement: float = Field(
        0.65,
        ge=0,
        le=1,
        description="A keyframe is taken once a smaller share of the readings both have agrees. Larger: more "
        "keyframes; smaller: occlusions and moving things are tracked against for longer.",
    )


class LoopClosureSettings(Settings):
    """Which keyframes that do not follow each other are measured against each other, and what is believed of it."""

    max_distance_m: float = Field(
        3.0,
        gt=0,
        le=100,
        description="Keyframes farther apart are no neighbours, metres. Larger: more pairs are looked at, more time.",
    )
    max_angle_deg: float = Field(
        60.0,
        gt=0,
        le=180,
        description="Keyframes that look in directions farther apart are no neighbours, degrees. Larger: more pairs "
        "are looked at, most of which share nothing.",
    )
    min_overlap: float = Field(
        0.3,
        gt=0,
        le=1,
        description="Share of a view that the other must see for the two to be measured, and that must fit. Smaller: "
        "more edges, more doubtful ones; larger: loops stay open.",
    )
    max_neighbors: int = Field(
        12,
        ge=0,
        description="Most neighbours a new keyframe is measured against while the camera moves, those that add most "
        "first; at the end all are that add anything. Larger: the queue falls behind.",
    )
    shortlist: int = Field(
        3,
        ge=0,
        description="Places of similar looks that a view is compared with. Larger: more loops found, some 20 ms each.",
    )
    min_similarity_sigmas: float = Field(
        4.0,
        ge=0,
        description="How far the similarity of a place worth checking stands out among those of all keyframes, robust "
        "standard deviations. Smaller: more checks that come to nothing; larger: loops from another side are missed.",
    )
    max_contradiction: float = Field(
        0.02,
        ge=0,
        le=1,
        description="Share of the readings both views have that may stand where the other saw through. Larger: "
        "look-alike places close false loops; smaller: moved things keep true ones open.",
    )
    min_color_correlation: float = Field(
        0.3,
        ge=-1,
        le=1,
        description="How much the colours of the surfaces that two views share must vary together (correlation). "
        "Larger: loops stay open where light changed; smaller: corners that differ in colour alone close false ones.",
    )
    drift_m: float = Field(
        0.25,
        ge=0,
        description="Error of position that drift may explain on any way, metres; what would need more is a place that "
        "looks alike. Larger: false loops; smaller: true loops are refused.",
    )
    drift_m_per_m: float = Field(
        0.04, ge=0, description="... and this much for each metre travelled. Larger or smaller: as for drift_m."
    )
    drift_deg: float = Field(
        5.0,
        ge=0,
        description="Error of direction that drift may explain on any way, degrees. Larger or smaller: as for drift_m.",
    )
    drift_deg_per_m: float = Field(
        1.0, ge=0, description="... and this much for each metre travelled. Larger or smaller: as for drift_m."
    )
    pairs_per_frame: int = Field(
        2,
        ge=0,
        description="Waiting pairs measured after each frame; the rest waits for the end. Larger: loops close sooner, "
        "each pair costs some 20 ms of the frame.",
    )


class DepthSettings(Settings):
    """The model of the depth sensor: standard deviation sigma_m + sigma_per_m2 (z - sigma_from_m)^2 at z metres
    (Nguyen, Izadi and Lovell, 3DIMPVT 2012)."""

    sigma_m: float = Field(
        0.0012,
        gt=0,
        le=0.5,
        description="Minimum standard deviation of depth, metres. Smaller: depth outweighs features, and readings "
        "are outliers sooner; larger: features decide.",
    )
    sigma_per_m2: float = Field(
        0.0019,
        ge=0,
        le=0.5,
        description="Its growth with the square of the distance, 1 / metre. Larger: far readings count less, as stereo "
        "cameras need; 0: a time-of-flight sensor that errs alike everywhere.",
    )
    sigma_from_m: float = Field(
        0.4,
        ge=0,
        le=10,
        description="Distance at which it is least, metres. Larger: the sensor is believed farther out, nearer "
        "readings less.",
    )
    max_depth_m: float = Field(
        4.0,
        gt=0,
        le=100,
        description="Farther readings are not registered, metres. Larger: halls and corridors have shape, under more "
        "noise; smaller: large rooms are lost.",
    )


class ColorSettings(Settings):
    """What is learnt of the colour camera besides its lens."""

    rolling_shutter: bool = Field(
        True,
        description="Whether the colour camera reads row by row; how long that takes is learnt. Off: all rows are "
        "taken to be of one moment, as a global shutter's are; with a rolling one poses stray while the camera turns.",
    )


class FreeSpaceSettings(Settings):
    """The check that nothing stands where another view looked through."""

    image_width: int = Field(
        80,
        ge=8,
        le=640,
        description="Pixels across of the reduced depth images that are compared. Larger: smaller things give "
        "look-alikes away; memory of each keyframe and time grow with the square.",
    )
    margin_m: float = Field(
        0.05,
        ge=0,
        le=1,
        description="How far in front of a reading something must stand to contradict it, metres. Smaller: noise "
        "contradicts true loops; larger: look-alikes pass.",
    )
    margin_per_m: float = Field(
        0.03,
        ge=0,
        le=1,
        description="... and this much more for each metre of the reading's depth. Smaller or larger: as for margin_m.",
    )


class SlamConfig(Settings):
    """All settings of the pose estimation."""

    features: FeatureSettings = FeatureSettings()
    keyframes: KeyframeSettings = KeyframeSettings()
    loop_closure: LoopClosureSettings = LoopClosureSettings()
    depth: DepthSettings = DepthSettings()
    color: ColorSettings = ColorSettings()
    free_space: FreeSpaceSettings = FreeSpaceSettings()
    submaps: SubmapSettings = SubmapSettings()
    refinement: RefinementSettings = RefinementSettings()
