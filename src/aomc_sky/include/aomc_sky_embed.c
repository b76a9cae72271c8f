/* Starts Python, opens a scene of aomc-sky and returns its sources; see aomc_sky_embed.h. C99.
 *
 *   cc -c aomc_sky_embed.c $(aomc-sky info --embed-flags)
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aomc_sky_embed.h"

#if defined(__STDC_VERSION__) && __STDC_VERSION__ >= 201112L && !defined(__STDC_NO_THREADS__)
#define THREAD_LOCAL _Thread_local
#elif defined(__GNUC__)
#define THREAD_LOCAL __thread
#else
#define THREAD_LOCAL
#endif

struct aomc_sky_scene {
    PyObject *opened; /* aomc_sky.source.embedding.Opened */
    int64_t n_bands;
};

static THREAD_LOCAL char error_text[8192];

const char *aomc_sky_error(void) { return error_text; }

static int fail(const char *text)
{
    snprintf(error_text, sizeof error_text, "%s", text);
    return -1;
}

/* Make an error text of the pending Python exception; errors of the package need no name of their class. */
static int fail_by_python(void)
{
    PyObject *value, *text;
    const char *message;

#if PY_VERSION_HEX >= 0x030C0000
    value = PyErr_GetRaisedException();
#else
    PyObject *type, *trace;
    PyErr_Fetch(&type, &value, &trace);
    PyErr_NormalizeException(&type, &value, &trace);
    Py_XDECREF(type);
    Py_XDECREF(trace);
#endif
    text = value != NULL ? PyObject_Str(value) : NULL;
    message = text != NULL ? PyUnicode_AsUTF8(text) : NULL;
    if (message == NULL) {
        PyErr_Clear();
        message = "an error without a text";
    }
    if (value == NULL || PyObject_HasAttrString(value, "exit_code") ||
        PyErr_GivenExceptionMatches(value, PyExc_IndexError)) {
        fail(message);
    } else {
        snprintf(error_text, sizeof error_text, "%s: %s", Py_TYPE(value)->tp_name, message);
    }
    Py_XDECREF(text);
    Py_XDECREF(value);
    return -1;
}

static const char *wanted_python(void)
{
    const char *path = getenv("AOMC_SKY_PYTHON");
    if (path != NULL && path[0] != '\0') {
        return path;
    }
#ifdef AOMC_SKY_PYTHON
    return AOMC_SKY_PYTHON;
#else
    return NULL;
#endif
}

/* Start Python once, without its signal handlers: Ctrl-C stays the program's own affair. It is never
 * ended, because numpy cannot be started twice. The lock is given back for the threads of the program. */
static int start_python(void)
{
    PyConfig config;
    PyStatus status;
    const char *python = wanted_python();

    if (Py_IsInitialized()) {
        return 0;
    }
    if (python != NULL && strchr(python, '/') != NULL) {
        FILE *file = fopen(python, "rb");
        if (file == NULL) {
            snprintf(error_text, sizeof error_text, "there is no Python %s; set AOMC_SKY_PYTHON", python);
            return -1;
        }
        fclose(file);
    }
    PyConfig_InitPythonConfig(&config);
    config.install_signal_handlers = 0;
    config.parse_argv = 0;
    status = PyStatus_Ok();
    if (python != NULL) {
        status = PyConfig_SetBytesString(&config, &config.program_name, python);
    }
    if (!PyStatus_Exception(status)) {
        status = Py_InitializeFromConfig(&config);
    }
    PyConfig_Clear(&config);
    if (PyStatus_Exception(status)) {
        return fail(status.err_msg != NULL ? status.err_msg : "Python cannot be started");
    }
    PyEval_SaveThread();
    return 0;
}

/* Call a function of aomc_sky.source.embedding; this takes over the arguments, which Py_BuildValue has made. */
static int open_by(const char *function, PyObject *arguments, aomc_sky_scene **scene)
{
    PyObject *module = PyImport_ImportModule("aomc_sky.source.embedding");
    PyObject *callable = module != NULL ? PyObject_GetAttrString(module, function) : NULL;
    PyObject *opened = callable != NULL && arguments != NULL ? PyObject_CallObject(callable, arguments) : NULL;
    PyObject *count = opened != NULL ? PyObject_GetAttrString(opened, "n_bands") : NULL;
    long long n_bands = count != NULL ? PyLong_AsLongLong(count) : -1;
    aomc_sky_scene *made = NULL;
    int status = 0;

    if (module == NULL && PyErr_ExceptionMatches(PyExc_ModuleNotFoundError)) {
        const char *advice = "; set AOMC_SKY_PYTHON to the Python that has aomc-sky";
        status = fail_by_python();
        strncat(error_text, advice, sizeof error_text - strlen(error_text) - 1);
    } else if (n_bands < 0 || PyErr_Occurred()) {
        status = fail_by_python();
    } else if ((made = malloc(sizeof *made)) == NULL) {
        status = fail("out of memory");
    } else {
        made->opened = opened;
        made->n_bands = n_bands;
        opened = NULL;
        *scene = made;
    }
    Py_XDECREF(count);
    Py_XDECREF(opened);
    Py_XDECREF(callable);
    Py_XDECREF(module);
    Py_XDECREF(arguments);
    return status;
}

int aomc_sky_open(const char *path, uint64_t seed, const char *options, aomc_sky_scene **scene)
{
    PyGILState_STATE lock;
    PyObject *arguments;
    int status;

    error_text[0] = '\0';
    if (path == NULL || scene == NULL) {
        return fail("aomc_sky_open: a pointer is NULL");
    }
    *scene = NULL;
    if (start_python() != 0) {
        return -1;
    }
    lock = PyGILState_Ensure();
    arguments = Py_BuildValue("(yKs)", path, (unsigned long long)seed, options != NULL ? options : "");
    status = open_by("open_scene", arguments, scene);
    PyGILState_Release(lock);
    return status;
}

int aomc_sky_open_run(const char *folder, aomc_sky_scene **scene)
{
    PyGILState_STATE lock;
    int status;

    error_text[0] = '\0';
    if (folder == NULL || scene == NULL) {
        return fail("aomc_sky_open_run: a pointer is NULL");
    }
    *scene = NULL;
    if (start_python() != 0) {
        return -1;
    }
    lock = PyGILState_Ensure();
    status = open_by("open_run", Py_BuildValue("(y)", folder), scene);
    PyGILState_Release(lock);
    return status;
}

int64_t aomc_sky_bands(const aomc_sky_scene *scene) { return scene == NULL ? 0 : scene->n_bands; }

int aomc_sky_band(aomc_sky_scene *scene, int64_t band, aomc_sky_source *source)
{
    unsigned long long address, numbers, context;
    long long n_photons;
    int is_double, status = 0;
    double wavelength_nm;
    PyObject *answer;
    PyGILState_STATE lock;

    error_text[0] = '\0';
    if (scene == NULL || source == NULL) {
        return fail("aomc_sky_band: a pointer is NULL");
    }
    memset(source, 0, sizeof *source);
    lock = PyGILState_Ensure();
    answer = PyObject_CallMethod(scene->opened, "source", "(L)", (long long)band);
    if (answer == NULL ||
        !PyArg_ParseTuple(answer, "KKKpLd", &address, &numbers, &context, &is_double, &n_photons, &wavelength_nm)) {
        status = fail_by_python();
    } else {
        /* POSIX promises that a function pointer fits an integer and comes back unchanged */
        source->next = is_double ? NULL : (aomc_sky_next)(uintptr_t)address;
        source->next_double = is_double ? (aomc_sky_next_double)(uintptr_t)address : NULL;
        source->numbers = is_double ? NULL : (aomc_sky_numbers)(uintptr_t)numbers;
        source->numbers_double = is_double ? (aomc_sky_numbers_double)(uintptr_t)numbers : NULL;
        source->context = (void *)(uintptr_t)context;
        source->n_photons = n_photons;
        source->wavelength_nm = wavelength_nm;
    }
    Py_XDECREF(answer);
    PyGILState_Release(lock);
    return status;
}

void aomc_sky_close(aomc_sky_scene *scene)
{
    PyGILState_STATE lock;
    PyObject *answer;

    if (scene == NULL) {
        return;
    }
    lock = PyGILState_Ensure();
    answer = PyObject_CallMethod(scene->opened, "close", NULL);
    if (answer == NULL) {
        PyErr_Clear();
    }
    Py_XDECREF(answer);
    Py_DECREF(scene->opened);
    PyGILState_Release(lock);
    free(scene);
}
