#pragma once

// Frame letters (Drake monogram notation: `p_BT` is the position of T's origin seen from B, expressed in B).
//
//   W   world. REP 103 as the surgeon sits: x forward (away from the surgeon), y left, z up. Origin: centre of the
//       FRS dome's base plate.
//   B   base of one arm, "frame 0" of the robot: origin at that arm's remote centre of motion (RCM).
//       gold: x up, y toward the surgeon, z right. green: x up, y forward, z left. (raven2.md 1.4)
//   T   tool tip: DH frame 6, `lw` (13 mm) beyond the wrist axis on the mid-line of the jaws.
//   I   ITP axes of a master: x forward, y right, z down, seen by the surgeon. (raven2.md 1.4)
//   C   camera, REP 103 optical: z forward, x right, y down.
