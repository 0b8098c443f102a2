#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

namespace rivage::client {

/// A command line with one of everything that the writers must know how to write.
struct SampleTree {
    CLI::App app{"Turns a thing into [another: thing].", "sample-tool"};
    std::string text;
    std::vector<std::string> texts;
    double number = 1;
    bool flag = false;

    SampleTree() {
        app.set_version_flag("--version", "1");
        app.require_subcommand(1);
        app.fallthrough();
        app.add_option("--server", text, "Where it is: 'here' or \\there")
            ->envname("SAMPLE_SERVER")
            ->type_name("URL");
        app.add_option("--timeout", number, "Seconds")
            ->capture_default_str()
            ->check(CLI::Range(0.5, 9.0))
            ->type_name("SECONDS");
        app.add_flag("-q,--quiet", flag, "Say nothing");
        app.add_flag("--inner-secret", flag, "Not for people")->group("");

        CLI::App* convert = app.add_subcommand("convert", "Convert it");
        convert->alias("cv");
        convert->add_option("IN", texts, "What to convert")->required();
        convert->add_option("-o,--out", text, "A file or '-'")->type_name("PATH");
        convert->add_option("--folder", text, "Where results go")->type_name("FOLDER");
        convert->add_option("--pack", text, "How it is packed")
            ->type_name("draco|none|NUMBER|XxYxZ");
        convert->add_option("--mode", text, "Which way")
            ->check(CLI::IsMember({"fast", "exact"}))
            ->group("Method");
        convert->add_option("--when", text, "At what time")
            ->check(CLI::IsMember({"now", "later"}))
            ->type_name("WHEN");
        convert->add_option("--tag", texts, "Any number of tags")->type_name("red|green");
        convert->add_option_group("Group")->add_option("--grouped", text, "One of a group");

        CLI::App* jobs = app.add_subcommand("jobs", "What runs");
        jobs->require_subcommand(1);
        CLI::App* fetch = jobs->add_subcommand("fetch", "Fetch a result");
        fetch->add_option("ID", text, "Which job")->required();
        fetch->add_option("--resume", text, "From where")->type_name("yes|no");
        jobs->add_subcommand("list", "List them");
        app.add_subcommand("shell", "Write a script")
            ->add_option("SHELL", text, "Which")
            ->type_name("bash|fish");
        app.add_subcommand("hidden-command", "Not for people")->group("");
    }
};

/// Every name of an option or command of the tree that --help shows, by command path.
inline void collectNames(const CLI::App& app, std::vector<std::string>& names) {
    for (const CLI::Option* option : app.get_options()) {
        if (option->get_group().empty()) continue;
        for (const std::string& name : option->get_lnames()) names.push_back(name);
    }
    for (const CLI::App* below : app.get_subcommands({})) {
        if (below->get_group().empty()) continue;
        if (!below->get_name().empty()) names.push_back(below->get_name());
        collectNames(*below, names);
    }
}

}  // namespace rivage::client
