"""Names of array types, by what is in them; shapes are said where they are used."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]
Float16Array = NDArray[np.float16]
Float32Array = NDArray[np.float32]
FloatArray = NDArray[np.floating]
IntArray = NDArray[np.integer]
Int32Array = NDArray[np.int32]
Int64Array = NDArray[np.int64]
Uint8Array = NDArray[np.uint8]
BoolArray = NDArray[np.bool_]
IndexArray = NDArray[np.intp]
Uint16Array = NDArray[np.uint16]
Int16Array = NDArray[np.int16]
Pose = Float64Array  # (4, 4) world_from_camera
