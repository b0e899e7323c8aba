"""Looks for what compiles here but not with GCC 9, CMake 3.16, Eigen 3.3.7 and Python 3.8."""

import ast
import re

from sources import cmake_files, cpp_files, finish, python_files

CPP_RULES = (
    (r"#include\s*<(bit|span|concepts|ranges|format|source_location|numbers|compare|barrier|latch|semaphore|stop_token"
     r"|syncstream|version|coroutine|expected|print)>", "a header of C++20 or later"),
    (r"\bconcept\s+\w+\s*=|\brequires\s*[\w(]+.*[;{]|\bconsteval\b|\bconstinit\b|\bco_(await|yield|return)\b|<=>",
     "a C++20 keyword"),
    (r"\bstd::(ssize|to_array|lerp|midpoint|bit_cast|erase_if|jthread|span|ranges|format|source_location|numbers"
     r"|make_shared_for_overwrite|make_unique_for_overwrite|remove_cvref|type_identity|bind_front)\b",
     "in the library since C++20"),
    (r"\.(starts_with|ends_with)\(", "in the library since C++20"),
    (r"\[\[(un)?likely\]\]|\[\[no_unique_address\]\]", "an attribute of C++20"),
    (r"[{,]\s*\.\w+\s*=[^=]", "a designated initialiser is C++20"),
    (r"\bfrom_chars\b.*(double|float)|(double|float).*\bfrom_chars\b|chars_format", "GCC 9 reads integers only"),
    (r"\bEigen::(seq|seqN|all|last|lastp1|placeholders|fix)\b|\bEigen::(Vector|RowVector)<", "Eigen 3.4"),
    (r"\.(reshaped|colwise\(\)\.begin|rowwise\(\)\.begin|cwiseArg)\(", "Eigen 3.4"),
    (r"\b(MatX|VecX|Mat3|Vec[34]|(Matrix|Vector|RowVector)[2-4X][difc])\s*\w*\s*[({]\s*\{", "Eigen 3.4: a list as initialiser"),
    (r"\b(parallel_policy|execution::par)", "needs TBB with GCC 9"),
)
CMAKE_RULES = (
    (r"\bcmake_path\s*\(|\bcmake_language\s*\(|\bblock\s*\(|\bFILE_SET\b|\bZIP_LISTS\b|string\s*\(\s*JSON|file\s*\(\s*(REAL_PATH"
     r"|CHMOD|ARCHIVE_CREATE|COPY_FILE)|\$<(PATH|LINK_LIBRARY|TARGET_RUNTIME_DLLS|DEVICE_LINK)|\bcmake_parse_arguments\(PARSE_ARGV"
     r"|return\s*\(\s*PROPAGATE", "later than CMake 3.16"),
    (r"cmake_minimum_required\s*\(\s*VERSION\s+(3\.(1[7-9]|[2-9]\d)|[4-9])", "later than CMake 3.16"),
)
PYTHON_RULES = (
    (r"\.remove(prefix|suffix)\(|\bfrom\s+itertools\s+import.*\b(pairwise|batched)|\bmath\.lcm\(|zip\(.*strict=", "later than Python 3.8"),
    (r"(->|:)\s*(list|dict|tuple|set)\[", "later than Python 3.8"),
    (r"\bctest\b.*--(test-dir|output-junit)|\bcmake\b.*--(fresh|preset)", "later than CMake 3.16"),
)


def without_comment(line, mark):
    return line.split(mark)[0]


def search(paths, rules, comment):
    for path in paths:
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            for pattern, words in rules:
                if re.search(pattern, without_comment(line, comment)):
                    yield path, number, words


def parse(paths):
    for path in paths:
        try:
            ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 8))
        except SyntaxError as error:
            yield path, error.lineno, f"not Python 3.8: {error.msg}"


def main():
    cpp, cmake = cpp_files(), cmake_files()
    python = [path for path in python_files() if path.name != "portability.py"]
    complaints = [
        *search(cpp, CPP_RULES, "//"),
        *search(cmake, CMAKE_RULES, "#"),
        *search(python, PYTHON_RULES, "#"),
        *parse(python),
    ]
    finish(complaints, len(cpp) + len(cmake) + len(python))


main()
