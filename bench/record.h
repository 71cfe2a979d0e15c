/*
 * The file of figures that a bench leaves, as bench/record.py explains it. A main takes the option before it looks at its
 * arguments, adds each figure, and ends:
 *
 *     bench_record_begin("table2", &count, words);
 *     bench_record_add("m65_posts1.fps", "", fps, 3);
 *     bench_record_end(renderer);
 *
 * Without `--figures FILE` among the arguments nothing is kept. One record a process, on one thread.
 */
#ifndef FURROW_BENCH_RECORD_H
#define FURROW_BENCH_RECORD_H

#include <stddef.h>

/* Takes `--figures FILE` out of the arguments, and notes the machine's load. `words` are to outlive the record. */
void bench_record_begin(const char *bench, int *count, char **words);
/* A figure: the median of `count` runs (at least 1), with the least and the most. Sorts them. `unit` may be "". */
void bench_record_add(const char *key, const char *unit, double *runs, size_t count);
/* Writes the file. Ends the program with a message if that fails. `renderer`: GL's name, or NULL if the bench has no GL. */
void bench_record_end(const char *renderer);

#endif
