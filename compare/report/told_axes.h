#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "common/model.h"
#include "common/results.h"

/// Axes in which wrenches are told: those of a body, by its place in the model, where 0 stands for global axes.
/// Nothing: each in the frame of its own side. They never decide what is judged.
namespace concord::compare {

/// The place of the body called `name`, or 0 of "world". Throws InputError, naming `file`, if there is none.
int told_axes(const Model& model, const std::string& name, const std::filesystem::path& file);

/// "global axes", "the axes of body crank", "its joint frame".
std::string words_of(const Model& model, std::optional<int> axes);

/// What stands before a component in the name of a column: "global.", "in_crank.", or nothing.
std::string prefix_of(const Model& model, std::optional<int> axes);

/// A wrench at an end [N, N m], given in the end's frame -> in the axes of a body. NaN where a component that has a
/// part along the axis is NaN.
Wrench told_wrench(const Attachment& end, const State& state, const Wrench& in_C, int axes);

/// The run with `in_C` of all reactions, total wrenches and wrenches of force elements in the axes of a body.
Trajectory told_run(const Model& model, Trajectory run, int axes);

}  // namespace concord::compare
