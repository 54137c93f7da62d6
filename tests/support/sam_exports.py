"""ONNX graphs with the signatures of SAM's exports, and so simple an inside that the right masks are known.

The features hold the image's brightness at a quarter of the model's resolution. Asked at a point, the decoder gives
what is as bright as the point; asked in a box, the box; and the opposite of both if the prompt does not end as this
export wants it. Of its masks for a point one is right, one repeats it with less quality, one has no firm border,
and, where there are four, the first is for prompts of several points only.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import onnx
import onnx.parser

_HEADER = '<ir_version: 8, opset_import: ["" : 17]>\n'
_BRIGHTNESS = """
    grey = ReduceMean<axes=[1], keepdims=1>(square)
    map = AveragePool<kernel_shape=[4,4], strides=[4,4]>(grey)
"""
_DEEP = """
    packed = SpaceToDepth<blocksize=4>(map)
    no_more = Constant<value_ints=[0,0,0,0,0,240,0,0]>()
    {name} = Pad(packed, no_more)
"""
_NORMALISED = """
    mean = Constant<value_floats=[123.675,116.28,103.53]>()
    deviation = Constant<value_floats=[58.395,57.12,57.375]>()
    centred = Sub(input_image, mean)
    scaled = Div(centred, deviation)
    chw = Transpose<perm=[2,0,1]>(scaled)
    zero = Constant<value_ints=[0]>()
    nchw = Unsqueeze(chw, zero)
    shape = Shape(nchw)
    whole = Constant<value_ints=[1,3,1024,1024]>()
    after = Sub(whole, shape)
    before = Constant<value_ints=[0,0,0,0]>()
    pads = Concat<axis=0>(before, after)
    square = Pad(nchw, pads)
"""
_SAM2 = """
    fine_pads = Constant<value_ints=[0,0,0,0,0,31,0,0]>()
    {fine} = Pad(map, fine_pads)
    half = AveragePool<kernel_shape=[2,2], strides=[2,2]>(map)
    half_pads = Constant<value_ints=[0,0,0,0,0,63,0,0]>()
    {middle} = Pad(half, half_pads)
"""


@dataclass(frozen=True)
class Export:
    """One way in which SAM models are exported; the graphs differ in nothing else.

    encoder, decoder: file names. family: "meta", "edge", "sam2", "hf" or "hf2". raw: the encoder takes (H, W, 3).
    """

    encoder: str
    decoder: str
    family: str
    raw: bool = False

    def write(self, folder: Path) -> Path:
        """Both files, in a folder."""
        for name, model in ((self.encoder, self.encoder_graph()), (self.decoder, self.decoder_graph())):
            onnx.checker.check_model(model)
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            onnx.save(model, folder / name)
        return folder

    @property
    def nested(self) -> bool:
        """Whether prompts come as (1, P, K, 2)."""
        return self.family.startswith("hf")

    @property
    def features(self) -> dict[str, str]:
        """Type and name of each feature map; the first three of SAM 2's are fine, middle, deep."""
        deep = "float[1,256,64,64]"
        return {
            "meta": {"image_embeddings": deep},
            "edge": {"image_embeddings": deep},
            "hf": {"image_embeddings": deep, "image_positional_embeddings": deep},
            "sam2": {"high_res_feats_0": "float[1,32,256,256]", "high_res_feats_1": "float[1,64,128,128]",
                     "image_embed": deep},
            "hf2": {"image_embeddings.0": "float[1,32,256,256]", "image_embeddings.1": "float[1,64,128,128]",
                    "image_embeddings.2": deep},
        }[self.family]  # fmt: skip

    def encoder_graph(self) -> onnx.ModelProto:
        """The image encoder."""
        names = list(self.features)
        source = "pixel_values" if self.nested else "image"
        taken = "float[image_height,image_width,3] input_image" if self.raw else f"float[1,3,1024,1024] {source}"
        body = _NORMALISED if self.raw else f"square = Identity({source})"
        body += _BRIGHTNESS + _DEEP.format(name=_id(names[2] if len(names) == 3 else names[0]))
        if len(names) == 3:
            body += _SAM2.format(fine=_id(names[0]), middle=_id(names[1]))
        elif len(names) == 2:
            body += f"{names[1]} = Neg({names[0]})"
        given = ", ".join(f"{kind} {_id(name)}" for name, kind in self.features.items())
        return _parsed(f"encoder ({taken}) => ({given}) {{{body}}}", names)

    def decoder_graph(self) -> onnx.ModelProto:
        """The prompt side."""
        features = [f"{kind} {_id(name)}" for name, kind in self.features.items()]
        outputs = ", ".join(f"{kind} {name}" for name, kind in self._outputs().items())
        first = next(iter(self.features))
        body = _unpacked(_id(first), self.features[first]) + self._prompt() + _ANSWER
        body += _FOUR if self.family in ("meta", "edge") else _THREE
        body += self._named_outputs()
        return _parsed(
            f"decoder ({', '.join([*features, *self._prompt_inputs()])}) => ({outputs}) {{{body}}}", list(self.features)
        )

    def _prompt_inputs(self) -> list[str]:
        mask = ["float[1,1,256,256] mask_input", "float[1] has_mask_input"]
        return {
            "meta": ["float[1,K,2] point_coords", "float[1,K] point_labels", *mask, "float[2] orig_im_size"],
            "edge": ["float[1,K,2] point_coords", "float[1,K] point_labels"],
            "sam2": ["float[P,K,2] point_coords", "float[P,K] point_labels", "float[P,1,256,256] mask_input",
                     "float[F] has_mask_input"],
            "hf": ["float[1,P,K,2] input_points", "int64[1,P,K] input_labels"],
            "hf2": ["float[1,P,K,2] input_points", "int64[1,P,K] input_labels", "float[1,B,4] input_boxes"],
        }[self.family]  # fmt: skip

    def _outputs(self) -> dict[str, str]:
        return {
            "meta": {"masks": "float[1,4,H,W]", "iou_predictions": "float[1,4]",
                     "low_res_masks": "float[1,4,256,256]"},
            "edge": {"scores": "float[1,4]", "masks": "float[1,4,256,256]"},
            "sam2": {"masks": "float[P,3,256,256]", "iou_predictions": "float[P,3]"},
            "hf": {"iou_scores": "float[1,P,3]", "pred_masks": "float[1,P,3,256,256]"},
            "hf2": {"iou_scores": "float[1,P,3]", "pred_masks": "float[1,P,3,256,256]",
                    "object_score_logits": "float[1,P,1]"},
        }[self.family]  # fmt: skip

    def _prompt(self) -> str:
        """Points (P, K, 2) and labels (P, K) as numbers; `ended` is 1 where a prompt ends as this export wants it."""
        if self.nested:
            text = """
            lead = Constant<value_ints=[0]>()
            pts = Squeeze(input_points, lead)
            flat_labels = Squeeze(input_labels, lead)
            lab = Cast<to=1>(flat_labels)
            """
        else:
            text = "pts = Identity(point_coords)\n lab = Identity(point_labels)\n"
        last = "minus = Constant<value_int=-1>()\n lastlab = Gather<axis=1>(lab, minus)\n"
        first = "nought = Constant<value_int=0>()\n firstlab = Gather<axis=1>(lab, nought)\n"
        text += last + first + "two = Constant<value_float=2.0>()\n isbox = Equal(firstlab, two)\n"
        text += "stop = Constant<value_float=-1.0>()\n stopped = Equal(lastlab, stop)\n"
        wants = {"meta": "Xor(stopped, isbox)", "edge": "Xor(stopped, isbox)", "hf2": "Identity(stopped)"}
        return text + f"asked = {wants.get(self.family, 'Not(stopped)')}\n ended = Cast<to=1>(asked)\n"

    def _named_outputs(self) -> str:
        if self.family == "meta":
            return """
            iou_predictions = Identity(quality)
            low_res_masks = Identity(answers)
            whole = Constant<value_ints=[1,4]>()
            size = Cast<to=7>(orig_im_size)
            target = Concat<axis=0>(whole, size)
            masks = Resize<mode="nearest">(answers, , , target)
            """
        if self.family == "edge":
            return "scores = Identity(quality)\n masks = Identity(answers)\n"
        if self.family == "sam2":
            return "iou_predictions = Identity(quality)\n masks = Identity(answers)\n"
        text = "iou_scores = Unsqueeze(quality, lead)\n pred_masks = Unsqueeze(answers, lead)\n"
        if self.family == "hf2":
            text += """
            total = ReduceSum<keepdims=1>(quality, one_axis)
            object_score_logits = Unsqueeze(total, lead)
            """
        return text


_ANSWER = """
    point = Gather<axis=1>(pts, nought)
    quarter = Constant<value_float=0.25>()
    cell = Mul(point, quarter)
    whole_cell = Floor(cell)
    xy = Cast<to=7>(whole_cell)
    reverse = Constant<value_ints=[1,0]>()
    yx = Gather<axis=1>(xy, reverse)
    value = GatherND(plane, yx)
    spread = Constant<value_ints=[1,2]>()
    level = Unsqueeze(value, spread)
    difference = Sub(plane, level)
    distance = Abs(difference)
    steep = Constant<value_float=-60.0>()
    falling = Mul(distance, steep)
    ten = Constant<value_float=10.0>()
    alike = Add(falling, ten)
    from = Constant<value_float=0.5>()
    to = Constant<value_float=256.5>()
    unit = Constant<value_float=1.0>()
    ramp = Range(from, to, unit)
    one_axis = Constant<value_ints=[1]>()
    column = Unsqueeze(ramp, one_axis)
    final = Constant<value_int=1>()
    one_there = Min(final, final)
    count = Shape(lab)
    length = Gather<axis=0>(count, final)
    ends = Sub(length, final)
    second = Min(one_there, ends)
    there = Gather<axis=1>(pts, second)
    cell_there = Mul(there, quarter)
    x0 = Gather<axis=1>(cell, nought)
    y0 = Gather<axis=1>(cell, final)
    x1 = Gather<axis=1>(cell_there, nought)
    y1 = Gather<axis=1>(cell_there, final)
    x0s = Unsqueeze(x0, spread)
    y0s = Unsqueeze(y0, spread)
    x1s = Unsqueeze(x1, spread)
    y1s = Unsqueeze(y1, spread)
    left = Sub(ramp, x0s)
    right = Sub(x1s, ramp)
    top = Sub(column, y0s)
    below = Sub(y1s, column)
    across = Min(left, right)
    down = Min(top, below)
    inside = Min(across, down)
    boxed = Unsqueeze(isbox, spread)
    good = Where(boxed, inside, alike)
    doubled = Add(ended, ended)
    plus_or_minus = Sub(doubled, unit)
    sign = Unsqueeze(plus_or_minus, spread)
    right_way_round = Mul(good, sign)
    as_four = Unsqueeze(right_way_round, one_axis)
    tenth = Constant<value_float=0.05>()
    vague = Mul(as_four, tenth)
"""
_THREE = """
    answers = Concat<axis=1>(as_four, as_four, vague)
    qualities = Constant<value_floats=[0.95,0.9,0.99]>()
    box_qualities = Constant<value_floats=[0.95,0.9,0.5]>()
    ended_column = Unsqueeze(ended, one_axis)
    boxed_column = Unsqueeze(isbox, one_axis)
    expected = Where(boxed_column, box_qualities, qualities)
    quality = Mul(ended_column, expected)
"""
_FOUR = """
    nothing = Neg(as_four)
    answers = Concat<axis=1>(nothing, as_four, as_four, vague)
    qualities = Constant<value_floats=[1.0,0.95,0.9,0.99]>()
    box_qualities = Constant<value_floats=[0.1,0.95,0.9,0.5]>()
    ended_column = Unsqueeze(ended, one_axis)
    boxed_column = Unsqueeze(isbox, one_axis)
    expected = Where(boxed_column, box_qualities, qualities)
    quality = Mul(ended_column, expected)
"""


def _unpacked(name: str, kind: str) -> str:
    """The brightness, as `plane` (256, 256), out of the first feature map."""
    if "64,64" in kind:
        text = """
        begin = Constant<value_ints=[0]>()
        some = Constant<value_ints=[16]>()
        channel_axis = Constant<value_ints=[1]>()
        used = Slice({name}, begin, some, channel_axis)
        fine = DepthToSpace<blocksize=4>(used)
        """
    else:
        text = """
        begin = Constant<value_ints=[0]>()
        some = Constant<value_ints=[1]>()
        channel_axis = Constant<value_ints=[1]>()
        fine = Slice({name}, begin, some, channel_axis)
        """
    return text.format(name=name) + "\n both = Constant<value_ints=[0,1]>()\n plane = Squeeze(fine, both)\n"


def _id(name: str) -> str:
    return name.replace(".", "__")


def _parsed(text: str, names: list[str]) -> onnx.ModelProto:
    """The model, with the dots in names that the text format does not know."""
    model = onnx.parser.parse_model(_HEADER + text)
    dotted = {_id(name): name for name in names}
    for value in [*model.graph.input, *model.graph.output]:
        value.name = dotted.get(value.name, value.name)
    for node in model.graph.node:
        for ports in (node.input, node.output):
            ports[:] = [dotted.get(name, name) for name in ports]
    return model


EXPORTS = {
    "mobile-sam": Export("mobile_sam_image_encoder.onnx", "sam_mask_decoder_multi.onnx", "meta", raw=True),
    "sam": Export("vit_b_encoder.onnx", "vit_b_decoder.onnx", "meta"),
    "edge-sam": Export("edge_sam_3x_encoder.onnx", "edge_sam_3x_decoder.onnx", "edge"),
    "sam2": Export("sam2_hiera_tiny.encoder.onnx", "sam2_hiera_tiny.decoder.onnx", "sam2"),
    "slim-sam": Export("onnx/vision_encoder.onnx", "onnx/prompt_encoder_mask_decoder.onnx", "hf"),
    "sam2.1": Export("onnx/vision_encoder.onnx", "onnx/prompt_encoder_mask_decoder.onnx", "hf2"),
}
