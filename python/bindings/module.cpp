#include <nanobind/stl/string_view.h>

#include "arrays.hpp"
#include "other_threads_run.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/version.hpp"

// The compiled part of the module `tactile`. The package python/tactile is what users see.
NB_MODULE(_tactile, module) {
  namespace python = tactile::python;
  nanobind::exception<tactile::Error>(module, "Error", PyExc_ValueError).attr("__doc__") =
      "Input that cannot be used: which, what is wrong with it, what would be right.";
  module.attr("version") = tactile::version();
  python::bind_recording(module);
  python::bind_heatmaps(module);
  python::bind_engine(module);
  python::bind_dataset(module);
  nanobind::module_::import_("atexit").attr("register")(nanobind::cpp_function([] { python::RunningLoops::all().end_all(); }));
}
