// Writes a TorchScript file for tests: `torchscript FILE`, with the methods of the module on stdin.
#include <torch/script.h>

#include <iostream>
#include <iterator>
#include <string>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  torch::jit::Module module("network");
  module.define(std::string(std::istreambuf_iterator<char>(std::cin), {}));
  module.save(argv[1]);
}
