/*
 * The values of each run: a grid (every value with every other), a list, or a Latin hypercube.
 *
 * A Latin hypercube of n runs cuts each parameter's range into n parts that are equally likely, and
 * takes one value from each (McKay, Beckman and Conover, Technometrics 21, 1979). Which part a run
 * gets is a random order of its own for each parameter. The random numbers are SplitMix64's
 * (Steele, Lea and Flood, 2014), whole arithmetic, so they are the same on every machine.
 */
#include <math.h>
#include <stdlib.h>

#include "scene/scene_error.h"
#include "study.h"

const char *study_value(const struct study *study, size_t run, size_t parameter)
{
	return study->values[run * study->parameter_count + parameter];
}

static void put_value(struct study *study, size_t run, size_t parameter, const char *value)
{
	study->values[run * study->parameter_count + parameter] = value;
}

/* A number as YAML. 12 digits hide what two machines' pow may differ by. */
static const char *number_text(struct study *study, double number)
{
	return study_print(study, "%.12g", number);
}

/* The value at a share of the range, from 0 to 1. */
static double range_at(const struct study_parameter *parameter, double share)
{
	if (parameter->logarithmic)
		return parameter->from * pow(parameter->to / parameter->from, share);
	if (parameter->whole)
		return fmin(floor(parameter->from + share * (parameter->to - parameter->from + 1)), parameter->to);
	return parameter->from + share * (parameter->to - parameter->from);
}

static enum status expand_ranges(struct study *study)
{
	for (size_t i = 0; i < study->parameter_count; i++) {
		struct study_parameter *parameter = &study->parameters[i];
		if (parameter->values != NULL)
			continue;
		TRY(mem_zeroed(&parameter->values, parameter->value_count, sizeof *parameter->values, "values of the study"));
		for (size_t k = 0; k < parameter->value_count; k++) {
			parameter->values[k] =
				number_text(study, range_at(parameter, (double)k / (double)(parameter->value_count - 1)));
			TRY_MEM(parameter->values[k], "values of the study");
		}
	}
	return STATUS_OK;
}

static enum status count_grid(struct study *study)
{
	size_t runs = 1;
	for (size_t i = 0; i < study->parameter_count; i++) {
		runs *= study->parameters[i].value_count;
		if (runs > STUDY_RUNS)
			return scene_error(study->file, study->parameters[i].node,
					   "makes more than %d runs; allowed: fewer values, or a hypercube", STUDY_RUNS);
	}
	study->run_count = runs;
	return STATUS_OK;
}

/* The last parameter changes fastest. */
static void fill_grid(struct study *study)
{
	for (size_t run = 0; run < study->run_count; run++) {
		size_t rest = run;
		for (size_t i = study->parameter_count; i-- > 0;) {
			const struct study_parameter *parameter = &study->parameters[i];
			put_value(study, run, i, parameter->values[rest % parameter->value_count]);
			rest /= parameter->value_count;
		}
	}
}

static uint64_t next_random(uint64_t *state)
{
	uint64_t x = *state += 0x9e3779b97f4a7c15u;
	x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
	x = (x ^ x >> 27) * 0x94d049bb133111ebu;
	return x ^ x >> 31;
}

/* Each parameter has random numbers of its own, by its name, so that a new parameter leaves the
 * others' values. */
static uint64_t random_of(uint64_t seed, const char *name)
{
	uint64_t state = 0xcbf29ce484222325u ^ seed;
	for (const char *c = name; *c != '\0'; c++)
		state = (state ^ (unsigned char)*c) * 0x100000001b3u;
	(void)next_random(&state);
	return state;
}

static enum status fill_hypercube(struct study *study)
{
	const size_t runs = study->run_count;
	size_t *part = mem_calloc(runs, sizeof *part);
	enum status status;
	TRY_OR(done, part != NULL ? STATUS_OK : fail_memory("the hypercube"));
	for (size_t i = 0; i < study->parameter_count; i++) {
		const struct study_parameter *parameter = &study->parameters[i];
		uint64_t state = random_of(study->seed, parameter->name);
		for (size_t run = 0; run < runs; run++)
			part[run] = run;
		for (size_t left = runs; left > 1; left--) {
			const size_t other = next_random(&state) % left, held = part[left - 1];
			part[left - 1] = part[other];
			part[other] = held;
		}
		for (size_t run = 0; run < runs; run++) {
			const double within = (double)(next_random(&state) >> 11) * 0x1p-53;
			const double share = ((double)part[run] + within) / (double)runs;
			const char *value;
			if (parameter->values != NULL) {
				const size_t index = (size_t)(share * (double)parameter->value_count);
				value = parameter->values[index < parameter->value_count ? index : parameter->value_count - 1];
			} else {
				value = number_text(study, range_at(parameter, share));
			}
			put_value(study, run, i, value);
			TRY_OR(done, value != NULL ? STATUS_OK : fail_memory("the hypercube"));
		}
	}
done:
	mem_free(part);
	return status;
}

enum status study_expand(struct study *study)
{
	if (study->design == STUDY_GRID) {
		TRY(expand_ranges(study));
		TRY(count_grid(study));
	}
	if (study->design == STUDY_LIST)
		study->run_count = study->parameters[0].value_count;
	study->values = mem_calloc(study->run_count * study->parameter_count, sizeof *study->values);
	study->runs = mem_calloc(study->run_count, sizeof *study->runs);
	TRY_MEM(study->values != NULL && study->runs != NULL, "runs of the study");
	if (study->design == STUDY_HYPERCUBE)
		return fill_hypercube(study);
	if (study->design == STUDY_GRID)
		fill_grid(study);
	for (size_t run = 0; run < study->run_count && study->design == STUDY_LIST; run++)
		for (size_t i = 0; i < study->parameter_count; i++)
			put_value(study, run, i, study->parameters[i].values[run]);
	return STATUS_OK;
}
