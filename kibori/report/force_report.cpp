// SPDX-License-Identifier: MIT
#include <kibori/report/force_report.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <functional>

#include <nlohmann/json.hpp>

namespace kibori {
namespace {

// A volume below this share of the removed volume is rounding error.
constexpr double kNegligible = 1e-9;

// Number of characters of a UTF-8 text: all bytes except continuation bytes.
int64_t letters(const std::string& text) {
  return std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; });
}

__attribute__((format(printf, 2, 3))) void append(std::string& to, const char* format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  to.append(text, static_cast<size_t>(std::clamp(length, 0, static_cast<int>(sizeof text) - 1)));
}

// A step of 1, 2 or 5 times a power of ten that divides `range` into at most `parts`.
double nice_step(double range, int parts) {
  const double raw = range / parts, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double m : {1.0, 2.0, 5.0})
    if (m * power >= raw * 0.999) return m * power;
  return 10 * power;
}

std::string number_text(double value, double step) {
  char text[32];
  const int digits = std::clamp(static_cast<int>(-std::floor(std::log10(step) + 1e-9)), 0, 9);
  std::snprintf(text, sizeof text, "%.*f", digits, std::abs(value) < step * 1e-6 ? 0.0 : value);
  return text;
}

// Three digits, or all digits before the point.
std::string size_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) >= 100 ? "%.0f" : "%.3g", value);
  return text;
}

struct Series {
  const char* name;
  const char* colour;
  double width;
  std::function<double(const TraceRow&)> value;
};

// Safe for colour-blind readers (Okabe and Ito).
constexpr const char *kBlack = "#222222", *kOrange = "#d55e00", *kBlue = "#0072b2",
                     *kGreen = "#009e73";

struct Panel {
  const char* title;
  const char* quantity;  // of the axis
  const char* unit;
  std::vector<Series> series;
};

// Same values as web/src/forces/robust.ts. The scale ends at kRoom times the value below which the
// share kShare of the nonzero values lies. If the maximum is at most kWorth times that, it is the
// end.
constexpr double kShare = 0.99, kRoom = 1.15, kWorth = 1.5;

// Computes the end of a scale for these values, so that a few spikes do not dominate it.
double reach(std::vector<double>& sizes) {
  if (sizes.empty()) return 0;
  const double largest = *std::max_element(sizes.begin(), sizes.end());
  const auto at =
      sizes.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  const double usual = kRoom * *at;
  return largest <= kWorth * usual ? largest : usual;
}

class Plot {
 public:
  Plot(const Carving& carving, const std::string& title, std::string note)
      : carving_(carving), note_(std::move(note)) {
    const double end = carving.trace.empty() ? 1 : carving.trace.back().time_s;
    t_max_ = std::max(end, 1e-6);
    // Ticks that share one point of the picture are drawn as their mean. Their range is a pale
    // band.
    window_ = std::max<size_t>(1, carving.trace.size() / 700);
    append(svg_,
           "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %d\" width=\"%d\" "
           "height=\"%d\" "
           "font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\" fill=\"%s\">\n"
           "<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
           kWidth, kHeight, kWidth, kHeight, kBlack);
    std::string safe;
    for (char c : title) safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    append(svg_, "<text x=\"%d\" y=\"30\" font-size=\"17\" font-weight=\"bold\">%s</text>\n", kLeft,
           safe.c_str());
  }

  void panel(const Panel& panel, double top, double height) {
    std::vector<double> above, below;
    for (const TraceRow& row : carving_.trace)
      for (const Series& s : panel.series) {
        const double v = s.value(row);
        if (v > 0) above.push_back(v);
        if (v < 0) below.push_back(-v);
      }
    double low = -reach(below), high = reach(above);
    if (high - low < 1e-12) high = 1;
    const double step = nice_step(high - low, 4);
    low = std::floor(low / step + 1e-9) * step;
    high = std::ceil(high / step - 1e-9) * step;
    const auto y_of = [&](double v) { return top + height * (high - v) / (high - low); };
    for (double v = low; v <= high + step / 2; v += step) {
      append(svg_, "<line x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"%s\"/>\n", kLeft,
             kRight, y_of(v), y_of(v), std::abs(v) < step / 1e6 ? "#999999" : "#e6e6e6");
      append(svg_, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\" fill=\"#555555\">%s</text>\n",
             kLeft - 8, y_of(v) + 4.5, number_text(v, step).c_str());
    }
    for (const Mark& mark : marks_)
      append(svg_,
             "<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"#888888\" "
             "stroke-dasharray=\"2 "
             "3\"/>\n",
             x_of(mark.time_s), x_of(mark.time_s), top, top + height);
    append(svg_, "<text x=\"%d\" y=\"%.1f\" font-weight=\"bold\">%s</text>\n", kLeft, top - 9,
           panel.title);
    append(svg_,
           "<text x=\"22\" y=\"%.1f\" transform=\"rotate(-90 22 %.1f)\" text-anchor=\"middle\">%s "
           "[%s]</text>\n",
           top + height / 2, top + height / 2, panel.quantity, panel.unit);
    double key = kRight;
    for (auto s = panel.series.rbegin(); s != panel.series.rend() && panel.series.size() > 1; ++s) {
      const double wide = std::max(
          24.0, 0.75 * kLetterWidth * static_cast<double>(std::string_view(s->name).size()));
      append(svg_,
             "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\" font-style=\"italic\">%s</text>", key,
             top - 9, s->name);
      append(svg_,
             "<line x1=\"%.1f\" x2=\"%.1f\" y1=\"%.1f\" y2=\"%.1f\" stroke=\"%s\" "
             "stroke-width=\"2.5\"/>\n",
             key - wide - 34, key - wide - 10, top - 13, top - 13, s->colour);
      key -= wide + 60;
    }
    append(svg_,
           "<clipPath id=\"panel%.0f\"><rect x=\"%d\" y=\"%.1f\" width=\"%d\" "
           "height=\"%.1f\"/></clipPath>\n",
           top, kLeft, top, kRight - kLeft, height);
    append(svg_, "<g clip-path=\"url(#panel%.0f)\">\n", top);
    for (const Series& s : panel.series) curve(s, y_of);
    append_long("</g>\n");
    for (const Series& s : panel.series) spikes(s, low, high, top, top + height, panel.unit);
  }

  std::string finish(double bottom) {
    const double step = nice_step(t_max_, 10);
    for (double t = 0; t <= t_max_ + step * 1e-6; t += step)
      append(svg_,
             "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" fill=\"#555555\">%s</text>\n",
             x_of(t), bottom + 20, number_text(t, step).c_str());
    append(svg_, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">Time [s]</text>\n",
           (kLeft + kRight) / 2.0, bottom + 42);
    append(svg_, "<text x=\"%d\" y=\"%.1f\" font-size=\"12\" fill=\"#555555\">%s</text>\n", kLeft,
           bottom + 70, note_.c_str());
    return std::move(svg_) + "</svg>\n";
  }

  // Draws labels over the first panel. Labels that would overlap are first moved to the right. Then
  // labels beyond the right edge are moved back.
  void marks(double y) {
    marks_ = contact_marks(carving_);
    struct Label {
      double x, half;  // middle, half the width
    };
    std::vector<Label> labels;
    double free = -1e9;  // right end of the previous label
    for (const Mark& mark : marks_) {
      const double half =
          std::max(10.5, kLetterWidth / 2 * static_cast<double>(letters(mark.label)) + 2);
      labels.push_back({std::max(x_of(mark.time_s), free + half), half});
      free = labels.back().x + half;
    }
    free = kWidth;
    for (size_t i = labels.size(); i-- > 0;) {
      labels[i].x = std::min(labels[i].x, free - labels[i].half);
      free = labels[i].x - labels[i].half;
    }
    for (size_t i = 0; i < labels.size(); i++) {
      append(svg_,
             "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\" font-size=\"15\" "
             "font-style=\"italic\">%s</text>\n",
             labels[i].x, y, marks_[i].label.c_str());
      append(svg_, "<path d=\"M%.1f %.1f L%.1f %.1f\" stroke=\"#888888\" fill=\"none\"/>\n",
             labels[i].x, y + 5, x_of(marks_[i].time_s), y + 14);
    }
  }

  static constexpr double kLetterWidth = 9;  // of the labels' font, on average [px]
  static constexpr int kWidth = 960, kHeight = 934, kLeft = 84, kRight = 936;

 private:
  double x_of(double t) const { return kLeft + (kRight - kLeft) * t / t_max_; }

  template <class Y>
  void curve(const Series& s, const Y& y_of) {
    const std::vector<TraceRow>& trace = carving_.trace;
    if (trace.empty()) return;
    std::string upper, lower, line;
    append(line, "M%.1f %.1f", x_of(0), y_of(0));
    for (size_t i = 0; i < trace.size(); i += window_) {
      const size_t end = std::min(trace.size(), i + window_);
      double min = s.value(trace[i]), max = min, sum = 0;
      for (size_t j = i; j < end; j++) {
        const double v = s.value(trace[j]);
        min = std::min(min, v);
        max = std::max(max, v);
        sum += v;
      }
      const double x = x_of(0.5 * (trace[i].time_s + trace[end - 1].time_s));
      append(line, " L%.1f %.2f", x, y_of(sum / static_cast<double>(end - i)));
      append(upper, "%s%.1f %.1f", upper.empty() ? "M" : " L", x, y_of(max));
      std::string back;
      append(back, " L%.1f %.1f", x, y_of(min));
      lower.insert(0, back);
    }
    if (window_ > 1)
      append_long("<path d=\"" + upper + lower + " Z\" fill=\"" + s.colour +
                  "\" fill-opacity=\"0.16\" stroke=\"none\"/>\n");
    append_long("<path d=\"" + line + "\" fill=\"none\" stroke=\"" + s.colour +
                "\" stroke-width=\"" + number_text(s.width, 0.1) +
                "\" stroke-linejoin=\"round\"/>\n");
  }
  // Marks values beyond the scale by triangles at the edge of the panel. A triangle stands for all
  // spikes within kApart. The largest value is written next to it, if there is room.
  void spikes(const Series& s, double low, double high, double top, double bottom,
              const char* unit) {
    constexpr double kApart = 8, kNumber = 56;  // distances of spikes, and of their numbers [px]
    struct Spike {
      double x, value;
    };
    std::vector<Spike> found;
    for (const TraceRow& row : carving_.trace) {
      const double value = s.value(row), x = x_of(row.time_s);
      if (value <= high && value >= low) continue;
      if (found.empty() || x - found.back().x > kApart || (found.back().value > 0) != (value > 0))
        found.push_back({x, value});
      else if (std::abs(value) > std::abs(found.back().value))
        found.back() = {x, value};
    }
    double free = kLeft;  // right end of the previous number
    for (const Spike& spike : found) {
      const bool up = spike.value > 0;
      append(svg_,
             "<path class=\"spike\" d=\"M%.1f %.1fl4 %dh-8z\" fill=\"%s\"><title>%s "
             "%s</title></path>\n",
             spike.x, up ? top - 7 : bottom + 7, up ? 7 : -7, s.colour,
             size_text(spike.value).c_str(), unit);
      const bool left = spike.x + 6 + kNumber > kRight;
      const double from = left ? spike.x - 6 - kNumber : spike.x + 6;
      if (from < free) continue;
      append(svg_, "<text x=\"%.1f\" y=\"%.1f\" font-size=\"10\" text-anchor=\"%s\">%s %s</text>\n",
             left ? spike.x - 6 : from, up ? top + 9 : bottom - 2, left ? "end" : "start",
             size_text(spike.value).c_str(), unit);
      free = from + kNumber;
    }
  }
  void append_long(const std::string& text) { svg_ += text; }

  const Carving& carving_;
  std::string note_;  // below the plot
  std::string svg_;
  std::vector<Mark> marks_;
  double t_max_ = 1;
  size_t window_ = 1;
};

double size_of(const Vec3& v) { return std::sqrt(v.squaredNorm()); }

bool two_hands(const Carving& carving) {
  return std::any_of(carving.trace.begin(), carving.trace.end(),
                     [](const TraceRow& row) { return row.second != nullptr; });
}

}  // namespace

std::vector<Mark> contact_marks(const Carving& carving) {
  // Adds contacts only between places whose labels are one letter, as in the paper. A prime after a
  // word would have no meaning.
  const auto is_letter = [](const Mark& mark) { return letters(mark.label) == 1; };
  std::vector<Mark> marks = carving.marks, result;
  for (size_t i = 0; i < marks.size(); i++) {
    result.push_back(marks[i]);
    if (i + 1 == marks.size()) break;
    if (!is_letter(marks[i]) || !is_letter(marks[i + 1])) continue;
    const TraceRow *first = nullptr, *last = nullptr;
    for (const TraceRow& row : carving.trace)
      if (row.time_s > marks[i].time_s && row.time_s <= marks[i + 1].time_s &&
          !row.result.wrench.force.isZero(0)) {
        if (!first) first = &row;
        last = &row;
      }
    if (!first) continue;
    result.push_back({marks[i].label + "′", first->time_s});
    if (last != first) result.push_back({marks[i + 1].label + "′", last->time_s});
  }
  return result;
}

std::string forces_csv(const Carving& carving) {
  std::string csv =
      "time_s,x_mm,y_mm,z_mm,ax,ay,az,removed_mm3,points,fx_N,fy_N,fz_N,mx_Nmm,my_Nmm,mz_Nmm\n";
  csv.reserve(csv.size() + carving.trace.size() * 160);
  const bool both = two_hands(carving);
  if (both) csv.insert(csv.size() - 1, ",hand");
  const auto put = [&](double time_s, const ToolTick& result, int hand) {
    const TickMotion& tick = result.motion;
    const Wrench& w = result.wrench;
    // + 0.0 turns -0 into 0.
    append(csv, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%lld,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g",
           time_s, tick.tip.x() + 0.0, tick.tip.y() + 0.0, tick.tip.z() + 0.0, tick.axis.x() + 0.0,
           tick.axis.y() + 0.0, tick.axis.z() + 0.0, result.removed_mm3 + 0.0,
           static_cast<long long>(result.points), w.force.x() + 0.0, w.force.y() + 0.0,
           w.force.z() + 0.0, w.moment.x() + 0.0, w.moment.y() + 0.0, w.moment.z() + 0.0);
    if (both) append(csv, ",%d", hand);
    csv += '\n';
  };
  for (const TraceRow& row : carving.trace) {
    put(row.time_s, row.result, 1);
    if (row.second) put(row.time_s, *row.second, 2);
  }
  return csv;
}

std::string model_title(const ForceLaw& law) {
  const std::string name(name_of(law.model));
  return law.model == ForceModel::series ? name : name + ", " + std::to_string(law.dof) + " DOF";
}

const char* model_note(ForceModel model) {
  switch (model) {
    case ForceModel::series:
      return "Series: a spring pulls the tool to the hand, F = k (hand − tool). The force grows "
             "until "
             "the wood gives way, and stays while the hand rests.";
    case ForceModel::energy:
      return "Energy: the force of the cut by the material's law and the removed volume, against "
             "the "
             "motion. It does not depend on the lattice or the rate, and it is zero at rest.";
    case ForceModel::paper:
      return "Paper: F = kf × lattice points removed in a tick, against the motion. It grows with "
             "the speed, is uneven where the points are few, and is zero at rest.";
  }
  return "";
}

std::string forces_svg(const Carving& carving, const std::string& title, const std::string& note) {
  Plot plot(carving, title, note);
  plot.marks(62);
  const double top = 112, height = 150, gap = 46;
  const auto force = [](int i) {
    return [i](const TraceRow& r) { return r.result.wrench.force[i]; };
  };
  const auto moment = [](int i) {
    return [i](const TraceRow& r) { return r.result.wrench.moment[i]; };
  };
  std::vector<Series> forces{
      {"|F|", kBlack, 1.8, [](const TraceRow& r) { return size_of(r.result.wrench.force); }}};
  std::vector<Series> moments{
      {"|M|", kBlack, 1.8, [](const TraceRow& r) { return size_of(r.result.wrench.moment); }}};
  if (two_hands(carving)) {
    forces.push_back({"second hand", kOrange, 1.8, [](const TraceRow& r) {
                        return r.second ? size_of(r.second->wrench.force) : 0;
                      }});
    moments.push_back({"second hand", kOrange, 1.8, [](const TraceRow& r) {
                         return r.second ? size_of(r.second->wrench.moment) : 0;
                       }});
  }
  plot.panel({"|F|: size of the force on the hand", "Force", "N", std::move(forces)}, top, height);
  plot.panel({"Its parts along x, y and z",
              "Force",
              "N",
              {{"Fx", kOrange, 1.4, force(0)},
               {"Fy", kGreen, 1.4, force(1)},
               {"Fz", kBlue, 1.4, force(2)}}},
             top + height + gap, height);
  plot.panel({"|M|: size of the moment about the tip", "Moment", "N mm", std::move(moments)},
             top + 2 * (height + gap), height);
  plot.panel({"Its parts about x, y and z",
              "Moment",
              "N mm",
              {{"Mx", kOrange, 1.4, moment(0)},
               {"My", kGreen, 1.4, moment(1)},
               {"Mz", kBlue, 1.4, moment(2)}}},
             top + 3 * (height + gap), height);
  return plot.finish(top + 4 * height + 3 * gap);
}

std::string summary_json(const CarveSummary& s) {
  char hash[32];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(s.state_hash));
  nlohmann::ordered_json json;
  json["ticks"] = s.ticks;
  json["removed_mm3"] = s.removed_mm3;
  json["deposited_mm3"] = s.deposited_mm3;
  json["volume_mm3"] = s.volume_mm3;
  json["points_removed"] = s.points_removed;
  json["max_force_N"] = s.max_force_N;
  json["max_moment_Nmm"] = s.max_moment_Nmm;
  json["state_hash"] = hash;
  json["step_us"] = {{"median", s.step_us.median},
                     {"p99", s.step_us.p99},
                     {"p999", s.step_us.p999},
                     {"max", s.step_us.max}};
  json["stock"] = {{"pitch_mm", s.pitch_mm},
                   {"rays", s.stock.rays},
                   {"spans", s.stock.spans},
                   {"bytes", s.stock.bytes}};
  if (s.without_force_mm3 > kNegligible * s.removed_mm3)
    json["without_force_mm3"] = s.without_force_mm3;
  if (s.fallen_mm3 != 0) json["fallen_mm3"] = s.fallen_mm3;
  if (s.bodies > 1) json["bodies"] = s.bodies;
  return json.dump(2) + "\n";
}

std::string summary_text(const CarveSummary& s) {
  std::string text;
  append(text, "ticks        %lld\n", static_cast<long long>(s.ticks));
  append(text, "removed      %.6g mm3 (%lld points)\n", s.removed_mm3,
         static_cast<long long>(s.points_removed));
  if (s.deposited_mm3 != 0) append(text, "deposited    %.6g mm3\n", s.deposited_mm3);
  if (s.without_force_mm3 > kNegligible * s.removed_mm3)
    append(text, "no force     from %.4g mm3, in the last cell before a stroke ended or reversed\n",
           s.without_force_mm3);
  if (s.fallen_mm3 != 0) append(text, "fallen       %.6g mm3\n", s.fallen_mm3);
  append(text, "left         %.6g mm3", s.volume_mm3);
  if (s.bodies > 1) append(text, " in %zu bodies", s.bodies);
  text += "\n";
  append(text, "max force    %.4g N, moment %.4g N mm\n", s.max_force_N, s.max_moment_Nmm);
  append(text, "step         median %.1f us, p99 %.1f, p99.9 %.1f, max %.1f\n", s.step_us.median,
         s.step_us.p99, s.step_us.p999, s.step_us.max);
  append(text, "model        pitch %g mm, %lld rays, %lld spans, %.2f MB\n", s.pitch_mm,
         static_cast<long long>(s.stock.rays), static_cast<long long>(s.stock.spans),
         static_cast<double>(s.stock.bytes) / 1e6);
  append(text, "state        %016llx\n", static_cast<unsigned long long>(s.state_hash));
  return text;
}

}  // namespace kibori
