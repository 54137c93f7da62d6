"""Dense patch features of image-text models: aligned with text (MaskCLIP), or the encoder's last tokens."""

from __future__ import annotations

from typing import Any

import torch


def has_aligned_features(model: Any) -> bool:
    """Whether the image tower is built like CLIP's or like SigLIP's."""
    vision = model.vision_model
    return hasattr(vision, "head") or (hasattr(model, "visual_projection") and hasattr(vision, "post_layernorm"))


def aligned_features(model: Any, pixels: dict[str, Any]) -> torch.Tensor:
    """Features (patches, D) in the space of texts."""
    has_head = hasattr(model.vision_model, "head")
    return _pooled_alone(model.vision_model, pixels) if has_head else _value_path(model, pixels)


def token_features(model: Any, pixels: dict[str, Any]) -> torch.Tensor:
    """The last tokens (patches, width), without the class token."""
    tokens = model.vision_model(**pixels).last_hidden_state[0]
    return tokens[1:] if hasattr(model.vision_model.embeddings, "class_embedding") else tokens


def _value_path(model: Any, pixels: dict[str, Any]) -> torch.Tensor:
    """MaskCLIP (Zhou et al., ECCV 2022): in the last block a patch takes its own value, as if it attended to nothing
    else, and neither the residual nor the MLP that follows."""
    vision = model.vision_model
    hidden = vision(**pixels, output_hidden_states=True).hidden_states[-2][0, 1:]
    last = vision.encoder.layers[-1]
    values = last.self_attn.out_proj(last.self_attn.v_proj(last.layer_norm1(hidden)))
    return model.visual_projection(vision.post_layernorm(values))


def _pooled_alone(vision: Any, pixels: dict[str, Any]) -> torch.Tensor:
    """The same idea for SigLIP, whose image vector is an attention over patches: each patch is pooled by itself."""
    tokens = vision(**pixels).last_hidden_state[0]
    return vision.head(tokens[:, None])
