// SPDX-License-Identifier: MIT
#include <kibori/edit/ray_edit.h>

#include <algorithm>

#include <kibori/dexel/normal_code.h>

namespace kibori {
namespace {

void write_span(Plane& plane, int slot, const Span& s) {
  plane.include(s.in, s.out);
  plane.in[slot] = s.in;
  plane.out[slot] = s.out;
  plane.material[slot] = s.material;
  plane.normal_in[slot] = s.normal_in;
  plane.normal_out[slot] = s.normal_out;
  if (plane.paint) {
    plane.paint->in[slot] = s.paint_in;
    plane.paint->out[slot] = s.paint_out;
  }
}

void write_with_paint(Field& field, Plane& plane, int slot, const Span& s) {
  if (s.paint_in | s.paint_out) field.paint_of(plane);
  write_span(plane, slot, s);
}

void clear_slot(Plane& plane, int slot) {
  plane.in[slot] = kFar;
  plane.out[slot] = -kFar;
}

// Inserts `span` at `plane`. Moves the spans from there on to the next planes.
void insert_span(Field& field, Plane& plane, int slot, Span span) {
  Plane* p = &plane;
  while (!p->empty_at(slot)) {
    const Span moved = FieldSnapshot::span_at(*p, slot);
    write_with_paint(field, *p, slot, span);
    span = moved;
    p = &field.next_plane(*p);
  }
  write_with_paint(field, *p, slot, span);
}

// Removes the span at `plane`. Moves the spans after it one plane back.
void erase_span(Field& field, Plane& plane, int slot) {
  Plane* p = &plane;
  while (p->next && !p->next->empty_at(slot)) {
    write_with_paint(field, *p, slot, FieldSnapshot::span_at(*p->next, slot));
    p = p->next;
  }
  clear_slot(*p, slot);
}

}  // namespace

void cut_ray(Field& field, Tile& tile, int slot, float a, float b) {
  for (Plane* p = &tile.first; p && !p->empty_at(slot);) {
    const float in = p->in[slot], out = p->out[slot];
    if (in >= b) break;
    if (out <= a) {
      p = p->next;
      continue;
    }
    if (in < a && out > b) {
      Span rest = FieldSnapshot::span_at(*p, slot);
      rest.in = b;
      rest.paint_in = 0;
      insert_span(field, field.next_plane(*p), slot, rest);
      p->out[slot] = a;
      break;
    }
    if (in < a) {
      p->out[slot] = a;
    } else if (out > b) {
      p->in[slot] = b;
    } else {
      erase_span(field, *p, slot);
      continue;
    }
    p = p->next;
  }
}

void keep_spans(Field& field, Tile& tile, int slot, const std::vector<bool>& keep) {
  Plane *to = &tile.first, *from = to;
  for (const bool stays : keep) {
    if (stays) {
      if (to != from) write_with_paint(field, *to, slot, FieldSnapshot::span_at(*from, slot));
      to = to->next;
    }
    from = from->next;
  }
  for (; to && !to->empty_at(slot); to = to->next) clear_slot(*to, slot);
}

void deposit_ray(Field& field, Tile& tile, int slot, float a, float b, uint8_t material) {
  // `a` moves up through the ray. Each gap before a span is filled; spans of the same material are
  // joined.
  Plane* p = &tile.first;
  Plane* before = nullptr;  // the span that ends exactly at a
  while (p && !p->empty_at(slot) && p->out[slot] < a) p = p->next ? p->next : &field.next_plane(*p);
  while (a < b) {
    const bool there = p && !p->empty_at(slot);
    if (there && p->in[slot] <= a) {
      // Inside (or at the end of) a span: continue at its end.
      a = std::max(a, p->out[slot]);
      before = p;
      p = &field.next_plane(*p);
      continue;
    }
    const float gap_end = there ? std::min(b, p->in[slot]) : b;
    const bool joins_before =
        before && before->out[slot] == a && before->material[slot] == material;
    const bool joins_after = there && p->in[slot] == gap_end && p->material[slot] == material;
    if (joins_before && joins_after) {
      before->out[slot] = p->out[slot];
      before->include(p->in[slot], p->out[slot]);
      before->normal_out[slot] = p->normal_out[slot];
      if (before->paint || p->paint)
        field.paint_of(*before).out[slot] = p->paint ? p->paint->out[slot] : 0;
      a = std::max(gap_end, before->out[slot]);
      erase_span(field, *p, slot);
    } else if (joins_before) {
      before->out[slot] = gap_end;
      before->include(a, gap_end);
      before->normal_out[slot] =
          there && p->in[slot] == gap_end ? negate_normal(p->normal_in[slot]) : 0;
      if (before->paint) before->paint->out[slot] = 0;
      a = gap_end;
    } else if (joins_after) {
      p->in[slot] = a;
      p->include(a, gap_end);
      p->normal_in[slot] =
          before && before->out[slot] == a ? negate_normal(before->normal_out[slot]) : 0;
      if (p->paint) p->paint->in[slot] = 0;
      a = gap_end;
    } else {
      Span fresh{a, gap_end, material, 0, 0, 0, 0};
      if (before && before->out[slot] == a)
        fresh.normal_in = negate_normal(before->normal_out[slot]);
      if (there && p->in[slot] == gap_end) fresh.normal_out = negate_normal(p->normal_in[slot]);
      insert_span(field, *p, slot, fresh);
      before = p;
      p = &field.next_plane(*p);
      a = gap_end;
    }
  }
}

}  // namespace kibori
