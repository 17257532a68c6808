#pragma once

#include <string>

namespace tactile::test {

/// A file of predictions, as `tactile eval --run` writes it.
inline const std::string prediction_text =
    "t_us,p_none,p_press,p_slip,verdict,label,truth,events,sample\n"
    "1000,0.9,0.05,0.05,none,none,none,80,\n"
    "3000,0.1,0.8,0.1,press,press,unlabelled,400,press\n"
    "5000,0.1,0.8,0.1,press,press,press,400,\n"
    "7000,0.9,0.05,0.05,none,none,none,80,none\n";

}  // namespace tactile::test
