/* CVODE on the model of the kernel, with events: peers/cvode.py loads it.
 *
 * The model is compiled from the kernel's own functions, see kernel_model.py. At an event (a contact begins,
 * ends, or has its impact speed latched anew) the solver is started anew, as the right-hand side is another.
 */
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#include <time.h>

extern int cvode_start(void *instance, double *y);
extern int cvode_rate(void *instance, const double *y, double *rate);
extern int cvode_roots(void *instance, int careful, const double *y, double *value);
extern int cvode_happen(void *instance, double time, const double *y, const int *found);
extern int cvode_weights(void *instance, int careful, const double *y, double *weight);
extern int cvode_look(void *instance, const double *y, double *seen);
extern int cvode_stop(void *instance, double time, const double *y);

enum { MOST_ROOTS = 256, OVER_BUDGET = -100 };

typedef struct {
    long states, candidates; /* sizes */
    long adams;              /* 1: Adams with fixed-point iteration; 0: BDF with dense Newton */
    /* 1: tolerance and end of contact adapted to the stiffness, see kernel_model.py */
    long careful;
    double budget;           /* s of CPU time */
} Settings;

typedef struct {
    long steps, rejected, rates, jacobians, restarts;
    long flag;      /* CVODE's flag, < 0 on failure */
    double seconds; /* of CPU time */
} Counts;

typedef struct {
    void *instance;
    const Settings *settings;
    Counts *counts;
} Problem;

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int rate(double t, N_Vector y, N_Vector out, void *data) {
    Problem *problem = data;
    (void)t;
    problem->counts->rates++;
    return cvode_rate(problem->instance, NV_DATA_S(y), NV_DATA_S(out));
}

static int roots(double t, N_Vector y, double *value, void *data) {
    Problem *problem = data;
    (void)t;
    return cvode_roots(problem->instance, (int)problem->settings->careful, NV_DATA_S(y), value);
}

static int weights(N_Vector y, N_Vector weight, void *data) {
    Problem *problem = data;
    return cvode_weights(problem->instance, (int)problem->settings->careful, NV_DATA_S(y), NV_DATA_S(weight));
}

static void silent(int code, const char *module, const char *function, char *message, void *data) {
    (void)code, (void)module, (void)function, (void)message, (void)data;
}

/* Add CVODE's counts, which restart at each start, to the sums. */
static void add_counts(void *cvode, Counts *sums) {
    long steps = 0, failed = 0, jacobians = 0;
    CVodeGetNumSteps(cvode, &steps);
    CVodeGetNumErrTestFails(cvode, &failed);
    CVodeGetNumJacEvals(cvode, &jacobians); /* stays 0 without a linear solver */
    sums->steps += steps;
    sums->rejected += failed;
    sums->jacobians += jacobians;
}

/* Return the counts until now, with the steps since the last start. */
static Counts so_far(void *cvode, const Counts *sums, double start) {
    Counts row = *sums;
    add_counts(cvode, &row);
    row.seconds = now() - start;
    return row;
}

/* Apply the found events, and start CVODE again. */
static int restart(void *cvode, Problem *problem, double t, N_Vector y) {
    int found[MOST_ROOTS];
    CVodeGetRootInfo(cvode, found);
    add_counts(cvode, problem->counts);
    problem->counts->restarts++;
    cvode_happen(problem->instance, t, NV_DATA_S(y), found);
    return CVodeReInit(cvode, t, y);
}

/* Solve up to each of the times [s] in turn, with one row of counts for each. Return the number of filled
   rows. If `seen` is not NULL, its three numbers are raised to the energy and the depths at each of the times. */
long cvode_solve(void *instance, const Settings *settings, const double *times, long count, Counts *rows,
                 double *seen) {
    Counts sums = {0};
    Problem problem = {instance, settings, &sums};
    long row = 0, flag = 0;
    double t = 0.0;
    if (2 * settings->candidates > MOST_ROOTS) return -1;

    SUNContext context;
    SUNContext_Create(NULL, &context);
    N_Vector y = N_VNew_Serial(settings->states, context);
    cvode_start(instance, NV_DATA_S(y));
    void *cvode = CVodeCreate(settings->adams ? CV_ADAMS : CV_BDF, context);
    CVodeInit(cvode, rate, 0.0, y);
    CVodeSetUserData(cvode, &problem);
    CVodeSetErrHandlerFn(cvode, silent, NULL);
    CVodeWFtolerances(cvode, weights);
    CVodeSetMaxNumSteps(cvode, 10000); /* in one call; after each call the budget is checked */
    CVodeRootInit(cvode, (int)(2 * settings->candidates), roots);
    CVodeSetNoInactiveRootWarn(cvode);
    SUNMatrix matrix = NULL;
    SUNLinearSolver linear = NULL;
    SUNNonlinearSolver fixed_point = NULL;
    if (settings->adams) {
        fixed_point = SUNNonlinSol_FixedPoint(y, 0, context);
        CVodeSetNonlinearSolver(cvode, fixed_point);
    } else {
        matrix = SUNDenseMatrix(settings->states, settings->states, context);
        linear = SUNLinSol_Dense(y, matrix, context);
        CVodeSetLinearSolver(cvode, linear, matrix); /* Jacobian: CVODE's difference quotients */
    }

    double start = now();
    while (row < count && flag >= 0) {
        flag = CVode(cvode, times[row], y, &t, CV_NORMAL);
        if (flag == CV_TOO_MUCH_WORK) flag = 0;
        if (flag == CV_ROOT_RETURN) flag = restart(cvode, &problem, t, y);
        else if (flag >= 0 && t == times[row]) {
            rows[row++] = so_far(cvode, &sums, start);
            if (seen) cvode_look(instance, NV_DATA_S(y), seen);
        }
        if (flag >= 0 && now() - start > settings->budget) flag = OVER_BUDGET;
    }
    if (flag < 0) {
        rows[row] = so_far(cvode, &sums, start);
        rows[row].flag = flag;
    }
    cvode_stop(instance, t, NV_DATA_S(y));

    CVodeFree(&cvode);
    if (linear) SUNLinSolFree(linear);
    if (matrix) SUNMatDestroy(matrix);
    if (fixed_point) SUNNonlinSolFree(fixed_point);
    N_VDestroy(y);
    SUNContext_Free(&context);
    return row;
}
