#pragma once

#include <QColor>

#include "panel_model.h"

namespace sinew {

/// The colour that a tone fills a badge or a bar with; white text is readable on each.
inline QColor fillColour(Tone tone) {
  switch (tone) {
    case Tone::kGood:
      return {32, 135, 75};
    case Tone::kCaution:
      return {196, 112, 8};
    case Tone::kBad:
      return {192, 38, 45};
    case Tone::kStale:
      return {140, 146, 156};
    case Tone::kPlain:
      break;
  }
  return {84, 96, 116};
}

}  // namespace sinew
