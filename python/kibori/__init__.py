# SPDX-License-Identifier: MIT
"""Kibori: carve virtual solids, and feel them.

    import kibori as kb
    m = kb.Model.block(size=(80, 50, 30), pitch=0.5)
    r = m.carve(kb.Ball(radius=5), [[10, 25, 28], [70, 25, 28]])
    r.removed_mm3, r.force

Lengths are mm, angles degrees, forces N, moments N mm. What can't be done raises kibori.Error with
one sentence.
"""
from ._kibori import *  # noqa: F401,F403
from ._kibori import Error, Model, __version__  # noqa: F401


def _repr_png_(self):
    return self.png(width=480, height=360, samples=16)


Model._repr_png_ = _repr_png_
