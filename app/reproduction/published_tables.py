"""The tables of the RAZER paper, with known errors corrected: numbers of other systems as the paper prints them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class PublishedTable:
    """preset: the rules; columns: what is compared; rows: numbers by method, None where none is printed; scenes: those
    of the table, empty = all that have a truth; notes: what is wrong in the paper, and what the numbers are;
    estimated_rows and estimated_notes: those under estimated poses, where the paper has them; has_component_times:
    whether the paper's times by component are of these scenes."""

    title: str
    preset: str
    columns: tuple[str, ...]
    rows: Mapping[str, tuple[float | None, ...]]
    scenes: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    estimated_rows: Mapping[str, tuple[float | None, ...]] = field(default_factory=dict)
    estimated_notes: tuple[str, ...] = ()
    has_component_times: bool = False

    def rows_of(self, poses: str | None) -> Mapping[str, tuple[float | None, ...]]:
        """What runs under such poses are compared with; slam = estimated ones."""
        return self.estimated_rows if poses == "slam" and self.estimated_rows else self.rows

    def notes_of(self, poses: str | None) -> tuple[str, ...]:
        """The notes on these rows."""
        if poses != "slam":
            return self.notes
        if not self.estimated_rows:
            return (*self.notes, "the rows above are under given poses: the paper has none under estimated ones")
        return self.estimated_notes


_SCENENN = ("011", "016", "030", "061", "078", "086", "096", "206", "223", "255")
_REPLICA = ("office0", "office1", "office2", "office3", "office4", "room0", "room1", "room2")
_SCANNET = ("scene0011_00", "scene0050_00", "scene0231_00", "scene0378_00", "scene0518_00")
_SEMANTIC = ("mIoU", "F-mIoU", "mAcc")
_MEAN_NOT_WEIGHTED = (
    "the paper prints the last column as f-mAcc; a frequency-weighted accuracy cannot be below F-mIoU, so it is "
    "HOV-SG's unweighted mAcc"
)

TABLES: dict[str, PublishedTable] = {
    "scenenn": PublishedTable(
        "SceneNN, AP50 by class in %",
        "scenenn",
        (*_SCENENN, "mean"),
        {
            "Voxblox++": (75, 48.2, 62.4, 66.7, 55.8, 20, 34.6, 79.6, 43.8, 75, 56.11),
            "Han et al.": (65.8, 50, 66.6, 43.3, 100, 56.9, 22.8, 92.1, 46.7, 33, 57.72),
            "Wang et al.": (62.2, 43, 60.7, 36.3, 49.3, 45.8, 32.7, 46.6, 56.4, 47.9, 47.9),
            "Li et al.": (78.6, 25, 58.6, 46.6, 69.8, 47.2, 26.7, 78.0, 48.5, 75, 55.4),
            "Mascaro et al.": (100, 75, 72.5, 50, 50, 50, 51.3, 74.1, 45.8, 100, 66.87),
            "INS-CONV": (100, 62, 83.4, 69.8, 93.7, 60, 57.6, 56.7, 78.6, 100, 76.18),
            "VolumePanoptic": (100, 73.3, 91.7, 62.4, 87.5, 61.7, 66.7, 83.3, 60, 100, 78.66),
            "RAZER (paper)": (100, 74.1, 91.8, 63.4, 88.4, 62.3, 66.8, 83.5, 61.2, 100, 79.15),
        },
        _SCENENN,
        (),
        {
            "Voxblox++": (61.5, 38.9, 50, 58.4, 44.3, 16.4, 27.6, 48.7, 40.7, 33.6, 42.01),
            "Han et al.": (53.4, 43.2, 50, 37.6, 75.6, 48.2, 13.4, 57.8, 44.1, 24.7, 44.8),
            "INS-CONV": (75, 46.7, 56.4, 57.1, 83.7, 22.4, 48.1, 28.1, 50, 28.1, 49.56),
            "VolumePanoptic": (75, 56.7, 72.3, 62.4, 68.9, 55.6, 33.2, 40.8, 65.2, 63.3, 59.34),
            "RAZER (paper)": (75.3, 57.6, 73.2, 63.4, 69.2, 59.2, 41.7, 58.8, 61.2, 63.4, 62.3),
        },
        (
            "the rows above are under the poses of ORB-SLAM3",
            "means are those of the rows: the paper prints 53.27 for INS-CONV and 58.82 for VolumePanoptic",
        ),
        has_component_times=True,
    ),
    "scannet200": PublishedTable(
        "ScanNet200 validation, AP in %",
        "scannet200",
        ("AP", "AP50", "AP25", "head", "common", "tail", "s a scene"),
        {
            "SAM3D": (6.1, 14.2, 21.3, 7.0, 6.2, 4.6, 482.6),
            "OVIR-3D": (13.0, 24.9, 32.3, 14.4, 12.7, 11.7, 466.8),
            "Open3DIS": (23.7, 29.4, 32.8, 27.8, 21.2, 21.8, 360.12),
            "OpenScene (2D fusion)": (11.7, 15.2, 17.8, 13.4, 11.6, 9.9, 46.45),
            "OpenScene (ensemble)": (5.3, 6.7, 8.1, 11.0, 3.2, 1.1, 46.78),
            "OpenMask3D": (15.4, 19.9, 23.1, 17.1, 14.1, 14.9, 553.87),
            "RAZER (paper)": (24.7, 31.7, 36.2, 27.8, 24.3, 21.6, 24.32),
        },
        notes=("times of the others are with an RTX 4090",),
    ),
    "replica": PublishedTable(
        "Replica, semantic segmentation",
        "hovsg",
        (*_SEMANTIC, "s a scene"),
        {
            "ConceptFusion (OVSeg)": (0.10, 0.21, 0.16, None),
            "ConceptFusion (ViT-H-14)": (0.10, 0.18, 0.17, None),
            "ConceptGraphs (OVSeg)": (0.13, 0.27, 0.21, None),
            "ConceptGraphs (ViT-H-14)": (0.18, 0.23, 0.30, None),
            "HOV-SG (OVSeg)": (0.144, 0.255, 0.212, 40320),
            "HOV-SG (ViT-H-14)": (0.231, 0.386, 0.304, 40320),
            "OpenNeRF": (None, None, None, 1143),
            "OVO": (None, None, None, 497),
            "RAZER (paper)": (0.320, 0.553, 0.414, 228),
        },
        _REPLICA,
        (_MEAN_NOT_WEIGHTED,),
    ),
    "scannet": PublishedTable(
        "ScanNet, semantic segmentation",
        "hovsg",
        _SEMANTIC,
        {
            "ConceptFusion (OVSeg)": (0.08, 0.11, 0.15),
            "ConceptFusion (ViT-H-14)": (0.11, 0.12, 0.21),
            "ConceptGraphs (OVSeg)": (0.15, 0.18, 0.23),
            "ConceptGraphs (ViT-H-14)": (0.16, 0.20, 0.28),
            "HOV-SG (OVSeg)": (0.214, 0.258, 0.420),
            "HOV-SG (ViT-H-14)": (0.222, 0.303, 0.431),
            "RAZER (paper)": (0.393, 0.508, 0.601),
        },
        _SCANNET,
        (_MEAN_NOT_WEIGHTED,),
    ),
    "retrieval": PublishedTable(
        "ScanNetv2, top-1 of 17 classes in %",
        "retrieval",
        ("class mean", "instance mean", "class mean, true masks", "instance mean, true masks"),
        {
            "PointCLIP": (6.3, None, None, None),
            "PointCLIP V2": (11.0, None, None, None),
            "CLIP2Point": (24.9, None, None, None),
            "PointCLIP with TP": (26.1, None, None, None),
            "CLIP2Point with TP": (35.2, None, None, None),
            "CLIP^2": (38.5, None, None, None),
            "Uni3D": (45.8, None, None, None),
            "OpenIns3D": (60.8, None, None, None),
            "RAZER (paper)": (73.5, None, None, None),
        },
        notes=("the paper prints 61.2 for itself; the mean over the classes of its own row is 73.5",),
    ),
}
