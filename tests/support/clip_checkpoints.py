"""Tiny image-text models with random weights, written by the libraries that write the large ones."""

from __future__ import annotations

import json
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

from razer.frame import Frame, Intrinsics, Masks

torch = pytest.importorskip("torch")
transformers = pytest.importorskip("transformers")

PICTURE, PATCH, DIMENSION, LENGTH = 32, 8, 24, 20
MEAN, STD = [0.5, 0.4, 0.3], [0.25, 0.3, 0.2]
_LAYERS = {"intermediate_size": 64, "num_hidden_layers": 2, "num_attention_heads": 4}
_TEXT = {**_LAYERS, "hidden_size": 32, "max_position_embeddings": LENGTH}
_VISION = {**_LAYERS, "hidden_size": 48, "patch_size": PATCH}
_WORDS = ("a", "red", "chair", "table", "photo", "of", "the", ".")


def colourful_frame() -> Frame:
    """A frame of 64 x 48 pixels of noise."""
    rgb = np.random.default_rng(0).integers(0, 256, (48, 64, 3), dtype=np.uint8)
    return Frame(0, 0.0, rgb, np.ones((48, 64), np.float32), Intrinsics(64, 48, 60, 60, 31.5, 23.5))


def overlapping_masks() -> Masks:
    """Masks of such a frame, the last one all of it."""
    where = np.zeros((5, 48, 64), bool)
    where[0, 5:20, 6:30] = where[1, :, 40:] = where[2, 30:33, 2:60] = where[3, 8:40, 8:40] = where[4] = True
    return Masks(where, np.ones(5, np.float32))


def clip_folder(folder: Path) -> Path:
    """CLIP with its byte-pair tokenizer."""
    tokenizer = _clip_tokenizer()
    text = {
        "vocab_size": len(tokenizer),
        "bos_token_id": tokenizer.bos_token_id,
        "eos_token_id": tokenizer.eos_token_id,
    }
    vision = {**_VISION, "image_size": PICTURE}
    config = transformers.CLIPConfig(text_config={**_TEXT, **text}, vision_config=vision, projection_dim=DIMENSION)
    return _saved(folder, transformers.CLIPModel(config), tokenizer)


def siglip_folder(folder: Path) -> Path:
    """SigLIP, and SigLIP 2 of fixed size, which has the same architecture."""
    vision = {**_VISION, "hidden_size": 32, "image_size": PICTURE}
    text = {**_TEXT, "vocab_size": 32, "projection_size": 32}
    return _saved(
        folder,
        transformers.SiglipModel(transformers.SiglipConfig(text_config=text, vision_config=vision)),
        _word_tokenizer(),
    )


def flexible_siglip_folder(folder: Path) -> Path:
    """SigLIP 2 for images of any shape (NaFlex)."""
    vision = {**_VISION, "hidden_size": 32, "num_patches": (PICTURE // PATCH) ** 2}
    text = {**_TEXT, "vocab_size": 32, "projection_size": 32}
    config = transformers.Siglip2Config(text_config=text, vision_config=vision)
    return _saved(folder, transformers.Siglip2Model(config), _word_tokenizer())


def onnx_folder(folder: Path, source: Path, *, batch: bool = True) -> Path:
    """The pair of graphs and their files as exports for transformers.js have them; batch False = one row only."""
    model = transformers.AutoModel.from_pretrained(source).eval()
    (folder / "onnx").mkdir(parents=True)
    for file in ("config.json", "preprocessor_config.json", "tokenizer.json", "tokenizer_config.json"):
        shutil.copy(source / file, folder / file)
    pixels, tokens = torch.zeros(1, 3, PICTURE, PICTURE), torch.ones(1, LENGTH, dtype=torch.long)
    towers = {
        "vision": (model.get_image_features, pixels, "pixel_values", "image_embeds"),
        "text": (model.get_text_features, tokens, "input_ids", "text_embeds"),
    }
    for name, (encode, example, taken, given) in towers.items():
        axes = {taken: {0: "batch_size"}, given: {0: "batch_size"}} if batch else None
        with warnings.catch_warnings():  # tracing warns of every branch that it takes
            warnings.simplefilter("ignore")
            torch.onnx.export(
                _Tower(model, encode),
                (example,),
                folder / "onnx" / f"{name}_model.onnx",
                input_names=[taken],
                output_names=[given],
                dynamic_axes=axes,
                dynamo=False,
            )
    return folder


class _Tower(torch.nn.Module):
    """One encoder of a model, as the function of one argument that an export is made of."""

    def __init__(self, model, encode):
        super().__init__()
        self.model, self.encode = model, encode

    def forward(self, values):
        return self.encode(values).pooler_output


def _saved(folder, model, tokenizer):
    generator = torch.Generator().manual_seed(0)
    with torch.no_grad():  # as initialised, models of this size hardly tell one text from another
        for parameter in model.parameters():
            parameter.copy_(0.4 * torch.randn(parameter.shape, generator=generator))
    model.save_pretrained(folder)
    tokenizer.save_pretrained(folder)
    pictures = {"image_mean": MEAN, "image_std": STD, "size": {"height": PICTURE, "width": PICTURE}}
    (folder / "preprocessor_config.json").write_text(json.dumps(pictures))
    return folder


def _clip_tokenizer():
    from tokenizers.pre_tokenizers import ByteLevel

    letters = sorted(ByteLevel.alphabet())
    pieces = [*letters, *(letter + "</w>" for letter in letters), "<|startoftext|>", "<|endoftext|>"]
    return transformers.CLIPTokenizer({piece: i for i, piece in enumerate(pieces)}, [])


def _word_tokenizer():
    from tokenizers import Tokenizer, models, pre_tokenizers, processors

    pieces = ["<pad>", "<eos>", "<unk>", *_WORDS]
    words = Tokenizer(models.WordLevel({piece: i for i, piece in enumerate(pieces)}, unk_token="<unk>"))
    words.pre_tokenizer = pre_tokenizers.Whitespace()
    words.post_processor = processors.TemplateProcessing(single="$A <eos>", special_tokens=[("<eos>", 1)])
    return transformers.PreTrainedTokenizerFast(
        tokenizer_object=words, pad_token="<pad>", eos_token="<eos>", unk_token="<unk>", model_max_length=LENGTH
    )
