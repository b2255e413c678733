"""Fills a history that concord has made with nights: python3 make_history.py FILE CASES NIGHTS.

Every number is drawn from a seed. Some cases have a story: a fall of digits, a rise of evaluations, a crash with last
words, an end by time, a case that is new or comes and goes, names in several scripts and with markup.
"""

import random
import sqlite3
import sys

file, cases, nights = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
draw = random.Random(1)
names = ["<img src=x onerror=alert(1)> & \"quoted\"", "мост/ось=1", "四連桿機構", "مفصل", "a_very_long_name_of_a_case/" + "length=0.3," * 9 + "rtol=1e-09"]
names += [f"machine_{k:02}" for k in range(cases - len(names))]
joints = [f"joint {joint} on {body}, {component}" for joint, body in [("A", "crank"), ("B", "coupler"), ("D", "slider")]
          for component in ["F_x", "F_y", "T_z"]]


def commit(night):
    """A new one every third night."""
    return f"{0x3f97bf0c1a2b + 7919 * ((night - 1) // 3):012x}"


class Story:
    """One case over the nights."""

    def __init__(self, number):
        self.number = number
        self.digits = 7.0 + draw.random() * 3.0
        self.steps = draw.randrange(200, 20000)
        self.wall = 0.01 * 10.0 ** draw.uniform(0.0, 3.0)

    def is_there(self, night):
        if self.number == 6:
            return night == nights
        return self.number != 7 or night % 9 < 6

    def ending(self, night):
        if night == nights and self.number in (8, 9, 10):
            return {8: ("crashed", "signal 11; last words: stage: same run\nt = 0.417 s: <b>the loop</b> of joint 'D' will not close"),
                    9: ("hung", "last words: stage: refined"),
                    10: ("differ", "joint D on slider, T_z, t = 1.284 s: cartesian +0.0127, relative -0.0127 N m, 0 digits (need 5): "
                         "same size, opposite sign in all 300 samples: check side, point and frame before the dynamics\n"
                         "to blame: relative, at joint D, in the term \"reporting\": breaks the audit's rule \"both sides\"")}[self.number]
        if self.number == 11 and night < nights:
            return "differ", "joint A on crank, F_x: 6.1 digits (need 8)"
        return "agree", ""

    def fall(self, night):
        return 2.0 if self.number == 12 and night > 0.6 * nights else 0.0

    def rise(self, night):
        return 1.3 if self.number in (0, 13) and night > 0.8 * nights else 1.0


connection = sqlite3.connect(file)
for table in ("component", "result", "night"):
    connection.execute(f"DELETE FROM {table}")
stories = [Story(k) for k in range(cases)]
row = 0
for night in range(1, nights + 1):
    started = f"2026-{1 + (night - 1) // 28:02}-{1 + (night - 1) % 28:02} 02:15:00"
    connection.execute(
        "INSERT INTO night(id, suite, started, finished, version, compiler, machine, suite_file, commit_words, process)"
        " VALUES(?, 'linkages', ?, ?, 'concord 0.1.0', ?, 'ci-3: x86_64, 2 processors, Linux 6.1', '', ?, '')",
        (night, started, started[:-5] + "29:13", "clang 14.0.6" if night < 50 else "clang 16.0.6", commit(night)))
    for name, story in zip(names, stories):
        if not story.is_there(night):
            continue
        ending, words = story.ending(night)
        is_lost = ending in ("crashed", "hung")
        row += 1
        steps = 0 if is_lost else int(story.steps * story.rise(night))
        connection.execute(
            "INSERT INTO result(id, night, name, work, ending, words, judged, total, integrator_cartesian, steps_cartesian,"
            " evaluations_cartesian, integrator_relative, steps_relative, evaluations_relative, wall_s, processor_s, definition)"
            " VALUES(?, ?, ?, 'compare', ?, ?, ?, ?, 'ida', ?, ?, 'gbs', ?, ?, ?, ?, 'as ever')",
            (row, night, name, ending, words, 0 if is_lost else len(joints), len(joints), steps, 2 * steps, steps // 3,
             4 * steps, story.wall * draw.uniform(0.9, 1.4), story.wall))
        for place, joint in enumerate([] if is_lost else joints):
            digits = story.digits + 0.3 * place + draw.uniform(-0.1, 0.1) - (story.fall(night) if place < 2 else 0.0)
            connection.execute(
                "INSERT INTO component(result, name, same_state, resolvable, same_run, refined, peak, scale, need_same_state,"
                " need_same_run, need_refined) VALUES(?, ?, ?, ?, ?, ?, ?, ?, 10, 6, 8.5)",
                (row, joint, digits + 5.0, digits + 4.2, digits, digits + 2.0, 100.0 + place, 110.0 + place))
connection.commit()
connection.close()
