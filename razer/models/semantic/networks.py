"""Semantic networks: an ONNX graph, or a checkpoint of `transformers`, as a function from images to class scores."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from numpy.typing import NDArray

from razer.arrays import Uint8Array
from razer.errors import BadInput
from razer.models.hub.model_file import model_file
from razer.models.runtime.checkpoint import Checkpoint
from razer.models.runtime.device import Device
from razer.models.runtime.onnx_graph import OnnxGraph
from razer.models.semantic.class_names import names_of, numbered_names
from razer.models.semantic.class_scores import class_scores, expected, layout_of
from razer.models.semantic.image_input import Colours, ImageInput


class SemanticNetwork(Protocol):
    """A network that says of what class each pixel is; class_names by number."""

    class_names: tuple[str, ...]

    def __call__(self, rgb: Uint8Array) -> NDArray:
        """Class numbers (h, w) int32, -1 = none, or logits (C, h, w) float32, which span an image (H, W, 3)."""


class OnnxNetwork:
    """A graph of one image and of any outputs, the first of which that can be classes counts. Raises BadInput."""

    def __init__(
        self,
        file: Path,
        names: str | Path | None,
        mean: Colours | None,
        std: Colours | None,
        size: int | None,
        device: Device,
    ) -> None:
        self.graph = OnnxGraph(file, device)
        self.class_names = names_of(file, self.graph.metadata, names)
        self.input = ImageInput.of(self.graph, mean, std, size)
        sides, n_classes = (self.input.rows, self.input.columns), len(self.class_names)
        outputs = self.graph.outputs.values()
        fitting = [output.name for output in outputs if layout_of(output.shape, n_classes, sides)]
        if not fitting:
            raise BadInput(f"{file} gives {', '.join(map(str, outputs))}, expected {expected(n_classes)}")
        self.output = fitting[0]

    def __call__(self, rgb: Uint8Array) -> NDArray:
        """Class numbers or logits that span the image; raises BadInput for outputs that are neither."""
        rows, columns = self.input.sides(rgb)
        outputs = self.graph({self.input.spec.name: self.input(rgb)})
        n_classes = len(self.class_names)
        try:
            return class_scores(outputs[self.output], n_classes, (rows, columns))
        except ValueError as error:
            raise BadInput(f"{self.graph.file} gives {error}, expected {expected(n_classes)}") from None


class CheckpointNetwork:
    """SegFormer, UperNet, BEiT, DPT, MobileViT and the like, as `save_pretrained` writes them. Raises BadInput."""

    def __init__(self, checkpoint: Checkpoint, names: str | Path | None, device: Device) -> None:
        self.checkpoint, self.device = checkpoint, device
        listed = checkpoint.config.get("id2label")
        source = f"{checkpoint.folder / 'config.json'}: its id2label"
        self.class_names = numbered_names(listed, source) if names is None else names_of(checkpoint.folder, {}, names)

    def __call__(self, rgb: Uint8Array) -> NDArray:
        """Logits (C, h, w) that span the image; raises BadInput where names and classes differ in number."""
        import torch  # late: the ONNX way needs none of it

        from razer.models.runtime.torch_device import torch_device

        model, processor = self._parts
        # A crop of the middle would leave the borders of the image without a class.
        options = {"do_center_crop": False} if getattr(processor, "do_center_crop", False) else {}
        with torch.inference_mode():
            inputs = processor(rgb, return_tensors="pt", **options).to(torch_device(self.device))
            logits: NDArray = model(**inputs).logits[0].float().cpu().numpy()
        if len(logits) != len(self.class_names):
            raise BadInput(f"{self.checkpoint.folder} has {len(logits)} classes, but {len(self.class_names)} names")
        return logits

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_parts"}

    @cached_property
    def _parts(self) -> tuple[Any, Any]:
        model = self.checkpoint.load("AutoModelForSemanticSegmentation", self.device)
        return model, self.checkpoint.part("AutoImageProcessor")


def open_network(
    weights: str | Path,
    names: str | Path | None,
    mean: Colours | None,
    std: Colours | None,
    size: int | None,
    device: Device,
) -> SemanticNetwork:
    """The network at a path or under a name: an ONNX file, a folder with model.onnx, or a checkpoint; the options as in
    SemanticSegmenter. Raises BadInput."""
    path = model_file(weights)
    if path.is_dir():
        inside = [file for file in (path / "model.onnx", path / "onnx" / "model.onnx") if file.is_file()]
        if not inside:
            if (mean, std, size) != (None, None, None):
                raise BadInput(f"options mean, std and size are for ONNX files: {path} says itself what it takes")
            return CheckpointNetwork(Checkpoint.of(path), names, device)
        path = inside[0]
    return OnnxNetwork(path, names, mean, std, size, device)
