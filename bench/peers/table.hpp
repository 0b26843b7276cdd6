// The files that pass between the contenders: doubles, little-endian; a table begins with its number of columns.
#pragma once

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

struct Table {
  std::size_t columns = 0;
  std::vector<double> values;

  std::size_t rows() const { return columns ? values.size() / columns : 0; }
  const double* row(std::size_t i) const { return values.data() + i * columns; }

  static Table read(const char* path) {
    std::ifstream in(path, std::ios::binary | std::ios::ate);
    if (!in) {
      std::fprintf(stderr, "%s cannot be read\n", path);
      std::exit(1);
    }
    const std::size_t count = std::size_t(in.tellg()) / sizeof(double);
    Table table;
    double columns = 0;
    in.seekg(0);
    in.read(reinterpret_cast<char*>(&columns), sizeof columns);
    table.columns = std::size_t(columns);
    table.values.resize(count - 1);
    in.read(reinterpret_cast<char*>(table.values.data()), std::streamsize((count - 1) * sizeof(double)));
    return table;
  }

  void write(const char* path) const {
    std::ofstream out(path, std::ios::binary);
    const double first = double(columns);
    out.write(reinterpret_cast<const char*>(&first), sizeof first);
    out.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size() * sizeof(double)));
  }

  // An answer: time [us], whether it calls the problem solved, its iterations; the caller adds the values.
  void begin_answer(double microseconds, bool solved, double iterations) {
    values.push_back(microseconds);
    values.push_back(solved ? 1.0 : 0.0);
    values.push_back(iterations);
  }
};

struct Clock {
  std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
  double microseconds() const {
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
  }
};

// What a model's list says: its coordinates but those of a floating base, and its contact points.
struct ModelList {
  struct Joint {
    std::string name;
    bool actuated;
    double effort;
  };
  struct Contact {
    std::string link;
    int foot;
    double position[3];
  };
  std::string torso;
  std::vector<Joint> joints;
  std::vector<Contact> contacts;

  bool planar() const { return !joints.empty() && !joints[0].actuated; }

  static ModelList read(const std::string& path) {
    ModelList list;
    std::ifstream in(path);
    if (!in) {
      std::fprintf(stderr, "%s cannot be read\n", path.c_str());
      std::exit(1);
    }
    std::string line, word;
    while (std::getline(in, line)) {
      std::istringstream words(line);
      words >> word;
      if (word == "torso") {
        words >> list.torso;
      } else if (word == "joint") {
        Joint joint;
        words >> joint.name >> joint.actuated >> joint.effort;
        list.joints.push_back(joint);
      } else if (word == "contact") {
        Contact contact;
        words >> contact.link >> contact.foot >> contact.position[0] >> contact.position[1] >> contact.position[2];
        list.contacts.push_back(contact);
      }
    }
    return list;
  }
};
