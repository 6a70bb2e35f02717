#include "render/stroke_font.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raven2_trainer::render {

namespace {

constexpr char kFirst = ' ';
constexpr char kLast = '~';
constexpr std::size_t kGlyphCount = kLast - kFirst + 1;

// Each pair of digits is a point x y: x 0..4, y 0 (top of capitals) .. 6 (base line) .. 8; a space lifts the pen.
constexpr std::array<const char*, kGlyphCount> kGlyphs{
    "",                                       // space
    "2024 26",                                // !
    "1012 3032",                              // "
    "1016 3036 0242 0444",                    // #
    "413010010213334445361605 2026",          // $
    "4006 0010110100 3545463635",             // %
    "46121120303104051626 2644",              // &
    "2022",                                   // '
    "30121436",                               // (
    "10323416",                               // )
    "2125 0244 4204",                         // *
    "2125 0343",                              // +
    "252617",                                 // ,
    "0343",                                   // -
    "26",                                     // .
    "4006",                                   // /
    "103041453616050110 3214",                // 0
    "112026 1636",                            // 1
    "0110304142330646",                       // 2
    "0110304142334445361605 1333",            // 3
    "36300444",                               // 4
    "400002324345361605",                     // 5
    "413010010516364544331304",               // 6
    "00402326",                               // 7
    "103041423313020110 130405163645443313",  // 8
    "051636454130100102133342",               // 9
    "22 26",                                  // :
    "22 252617",                              // ;
    "410345",                                 // <
    "0242 0444",                              // =
    "014305",                                 // >
    "011030414224 26",                        // ?
    "34322213142434444241301001051636",       // @
    "0602204246 0444",                        // A
    "00304142330300 334445360603",            // B
    "4130100105163645",                       // C
    "0030414536060000",                       // D
    "40000646 0333",                          // E
    "400006 0333",                            // F
    "41301001051636454323",                   // G
    "0006 4046 0343",                         // H
    "1030 2026 1636",                         // I
    "4045361605",                             // J
    "0006 4003 0346",                         // K
    "000646",                                 // L
    "0600234046",                             // M
    "06004640",                               // N
    "103041453616050110",                     // O
    "06003041423303",                         // P
    "103041453616050110 2446",                // Q
    "06003041423303 2346",                    // R
    "413010010213334445361605",               // S
    "0040 2026",                              // T
    "000516364540",                           // U
    "002640",                                 // V
    "0016233640",                             // W
    "0046 4006",                              // X
    "002340 2326",                            // Y
    "00400646",                               // Z
    "30101636",                               // [
    "0046",                                   // backslash
    "10303616",                               // ]
    "022042",                                 // ^
    "0747",                                   // _
    "1021",                                   // `
    "12324346 4414051646",                    // a
    "0006 0312324345361605",                  // b
    "4332120305163645",                       // c
    "4046 4332120305163645",                  // d
    "04444332120305163645",                   // e
    "40302126 1232",                          // f
    "4247381807 4332120305163645",            // g
    "0006 0312324346",                        // h
    "20 122226 1636",                         // i
    "30 2232372818",                          // j
    "0006 4204 1346",                         // k
    "10202536",                               // l
    "0602 03122326 23324346",                 // m
    "0206 0312324346",                        // n
    "123243453616050312",                     // o
    "0208 0312324345361605",                  // p
    "4248 4332120305163645",                  // q
    "0206 03123243",                          // r
    "4332120314344536160505",                 // s
    "20253645 0242",                          // t
    "0205163645 4246",                        // u
    "022642",                                 // v
    "0216243642",                             // w
    "0246 4206",                              // x
    "0226 422608",                            // y
    "02420646",                               // z
    "302122132425 2536",                      // {
    "2027",                                   // |
    "102122332425 2516",                      // }
    "04123442",                               // ~
};

constexpr double kAdvance = 5.5;    // [units]
constexpr double kCellRows = 10.2;  // [units] with the descenders
constexpr double kPen = 0.85;       // [units] width of a stroke
constexpr double kLeft = 0.75;      // [units] margin in the cell
constexpr double kTop = 1.0;        // [units]

struct Point {
  double x, y;
};

double distanceToSegment(Point p, Point a, Point b) {
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  const double t = length2 > 0.0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

/** [units] Distance from the nearest stroke; large for an empty glyph. */
double distanceToGlyph(const char* glyph, Point p) {
  double nearest = 1e9;
  bool pen_down = false;
  Point last{};
  for (const char* c = glyph; *c != '\0';) {
    if (*c == ' ') {
      pen_down = false;
      ++c;
      continue;
    }
    const Point next{static_cast<double>(c[0] - '0'), static_cast<double>(c[1] - '0')};
    nearest = std::min(nearest, distanceToSegment(p, pen_down ? last : next, next));
    last = next;
    pen_down = true;
    c += 2;
  }
  return nearest;
}

/** Coverage of a pixel from how far its centre lies from the stroke's edge. */
std::uint8_t coverage(const char* glyph, int column, int row, double unit) {
  const Point p{(column + 0.5) / unit - kLeft, (row + 0.5) / unit - kTop};
  const double inside_px = (kPen / 2.0 - distanceToGlyph(glyph, p)) * unit;
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(inside_px + 0.5, 0.0, 1.0)));
}

}  // namespace

StrokeFont::StrokeFont(double unit)
    : cell_width_(static_cast<int>(std::lround(kAdvance * unit))),
      cell_height_(static_cast<int>(std::lround(kCellRows * unit))) {
  masks_.reserve(kGlyphCount * static_cast<std::size_t>(cell_width_ * cell_height_));
  for (const char* glyph : kGlyphs) {
    for (int row = 0; row < cell_height_; ++row) {
      for (int column = 0; column < cell_width_; ++column)
        masks_.push_back(coverage(glyph, column, row, unit));
    }
  }
}

const std::uint8_t* StrokeFont::mask(char c) const noexcept {
  const char shown = c < kFirst || c > kLast ? '?' : c;
  return masks_.data() +
         static_cast<std::size_t>(shown - kFirst) * static_cast<std::size_t>(cell_width_ * cell_height_);
}

}  // namespace raven2_trainer::render
