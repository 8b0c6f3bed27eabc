"""Square matrices as fields of a value, with their size for whoever reads them from a text."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic_core import core_schema


@dataclass(frozen=True, slots=True)
class Square:
    """Size of a matrix; pydantic reads it from nested lists and writes it to them."""

    size: int

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        """Return how pydantic reads and writes the matrix."""
        return core_schema.no_info_plain_validator_function(
            self.read,
            serialization=core_schema.plain_serializer_function_ser_schema(lambda m: m.tolist()),
        )

    def read(self, value: Any) -> NDArray[np.float64]:
        """Return nested lists as a matrix. Raises ValueError for another size, nan and inf."""
        size = self.size
        try:
            matrix = np.array(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            matrix = np.empty(0)
        if matrix.shape != (size, size) or not np.isfinite(matrix).all():
            raise ValueError(f"must be a {size} x {size} matrix of finite numbers")
        return matrix


Matrix3 = Annotated[NDArray[np.float64], Square(3)]
Matrix4 = Annotated[NDArray[np.float64], Square(4)]
