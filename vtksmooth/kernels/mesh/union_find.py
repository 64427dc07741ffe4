"""Disjoint sets: which things hang together, found by joining them pair by pair (union-find)."""

from __future__ import annotations

from ...jit.compiled import device


@device
def find_root(parent, v):
    """Return the root of v's set. `parent` (int32) begins as 0, 1, 2, ...; the way to the root is halved."""
    while parent[v] != v:
        parent[v] = parent[parent[v]]
        v = parent[v]
    return v


@device
def join(parent, v, w):
    """Make one set of those of v and w. Its root is its smallest member, whatever came first."""
    a = find_root(parent, v)
    b = find_root(parent, w)
    parent[max(a, b)] = min(a, b)
